// What the reference's own work costs beside the bare traversal of the same rays, and what adaptive
// stopping saves. Counters: rays/s, and on the reference's lines `of_bare`, its share of the bare
// loop's rays/s measured just before.

#include <benchmark/benchmark.h>
#include <embree3/rtcore.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>

#include "core/frame/gbuffer.hpp"
#include "harness/reference/pixel_estimator.hpp"
#include "harness/reference/reference.hpp"

namespace penumbra {
namespace {

constexpr int kSize = 160;  // pixels across: all rays of an image of this size fit into 2 GiB

/// Looks through a tracer and keeps every ray.
class RecordingProbe final : public LightProbe {
  public:
    RecordingProbe(const Tracer& tracer, const AreaLight& light, std::vector<RTCRay>& rays)
        : tracer_(tracer), stream_(tracer), light_(light), rays_(rays) {}

    void moveTo(const glm::vec3& position, const glm::vec3& normal) {
        origin_ = tracer_.shadowOrigin(position, normal);
    }
    void weigh(LightBatch& batch) override { std::fill_n(batch.weight.begin(), batch.size, 1.0f); }
    void look(LightBatch& batch) override {
        stream_.clear();
        for (std::size_t i = 0; i < batch.size; ++i) {
            const glm::vec3 target(light_.at(batch.s[i], batch.t[i]));
            stream_.add(origin_, target);
            RTCRay ray{};
            ray.org_x = origin_.x, ray.org_y = origin_.y, ray.org_z = origin_.z;
            ray.dir_x = target.x - origin_.x;
            ray.dir_y = target.y - origin_.y;
            ray.dir_z = target.z - origin_.z;
            ray.mask = ~0u;
            rays_.push_back(ray);
        }
        stream_.trace();
        for (std::size_t i = 0; i < batch.size; ++i) batch.visible[i] = !stream_.blocked(i);
    }

  private:
    const Tracer& tracer_;
    Tracer::Stream stream_;
    AreaLight light_;
    std::vector<RTCRay>& rays_;
    glm::vec3 origin_{0.0f};
};

/// One scene with its points, its reference's rays, and an Embree scene of its own.
struct Subject {
    std::shared_ptr<const Scene> scene;
    SceneFrame frame;
    std::unique_ptr<Tracer> tracer;
    GBuffer gbuffer;
    std::vector<RTCRay> rays;
    double bareRaysPerS = 0.0;
    RTCDevice device = nullptr;
    RTCScene bare = nullptr;

    explicit Subject(const std::string& id) : scene(loadScene(id, SceneLibrary::standard())) {
        frame = scene->frame(0);
        tracer = std::make_unique<Tracer>(frame.geometry, scene->materials, scene->images);
        gbuffer = renderGBuffer(*tracer, frame, *scene, kSize, kSize);
        record();
        buildBare();
    }

    /// The rays that the reference's main pass sends, in its order.
    void record() {
        const ReferenceOptions options;
        const ReplicateTables tables(options.maxRaysPerPixel / ReplicateTables::kReplicates);
        const PixelEstimator estimator(tables, options.targetStandardError,
                                       options.maxRaysPerPixel);
        RecordingProbe probe(*tracer, frame.light, rays);
        for (std::size_t i = 0; i < gbuffer.size(); ++i) {
            if (gbuffer.mask[i] != PixelClass::scored && gbuffer.mask[i] != PixelClass::horizon)
                continue;
            probe.moveTo(gbuffer.position[i], gbuffer.geometricNormal[i]);
            estimator.adaptive(probe, static_cast<std::uint32_t>(i));
        }
    }

    void buildBare() {
        device = rtcNewDevice(nullptr);
        bare = rtcNewScene(device);
        rtcSetSceneFlags(bare, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(bare, RTC_BUILD_QUALITY_HIGH);
        RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        const Geometry& g = *frame.geometry;
        std::ranges::copy(g.positions, static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
                                           mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(glm::vec3), g.positions.size())));
        std::ranges::copy(g.indices, static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
                                         mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                         3 * sizeof(std::uint32_t), g.triangleCount())));
        rtcCommitGeometry(mesh);
        rtcAttachGeometry(bare, mesh);
        rtcReleaseGeometry(mesh);
        rtcCommitScene(bare);
    }

    ~Subject() {
        rtcReleaseScene(bare);
        rtcReleaseDevice(device);
    }
    Subject(const Subject&) = delete;
    Subject& operator=(const Subject&) = delete;
};

Subject& subject(const std::string& id) {
    static std::map<std::string, std::unique_ptr<Subject>> subjects;
    auto& entry = subjects[id];
    if (!entry) entry = std::make_unique<Subject>(id);
    return *entry;
}

double secondsOf(const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// rtcOccluded1M over the recorded rays, streams of 256, and nothing else.
void bareTraversal(benchmark::State& state, const std::string& id) {
    Subject& s = subject(id);
    double seconds = 0.0, rays = 0.0;
    for (auto _ : state) {
        for (RTCRay& ray : s.rays) ray.tfar = 1.0f - 1e-4f;
        const std::size_t streams = (s.rays.size() + Tracer::kStreamSize - 1) / Tracer::kStreamSize;
        const double t = secondsOf([&] {
            tbb::parallel_for(std::size_t{0}, streams, [&](std::size_t k) {
                RTCIntersectContext context;
                rtcInitIntersectContext(&context);
                context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
                const std::size_t first = k * Tracer::kStreamSize;
                rtcOccluded1M(
                    s.bare, &context, &s.rays[first],
                    static_cast<unsigned>(std::min(Tracer::kStreamSize, s.rays.size() - first)),
                    sizeof(RTCRay));
            });
        });
        state.SetIterationTime(t);
        seconds += t;
        rays += static_cast<double>(s.rays.size());
    }
    s.bareRaysPerS = rays / seconds;
    state.counters["rays/s"] = s.bareRaysPerS;
}

/// traceReference as a run calls it.
void reference(benchmark::State& state, const std::string& id) {
    Subject& s = subject(id);
    double seconds = 0.0, rays = 0.0;
    for (auto _ : state) {
        Reference result;
        const double t = secondsOf([&] {
            result = traceReference(*s.tracer, s.gbuffer, s.frame.light, ReferenceOptions{});
        });
        state.SetIterationTime(t);
        seconds += t;
        rays += result.totalRays();
    }
    state.counters["rays/s"] = rays / seconds;
    state.counters["of_bare"] = rays / seconds / s.bareRaysPerS;
}

/// Rays of adaptive stopping over the rays of one count for all pixels that brings every pixel's
/// standard error down to adaptive's worst.
void adaptiveShare(benchmark::State& state, const std::string& id) {
    Subject& s = subject(id);
    const auto worst = [&](const Reference& r) {
        float most = 0.0f;
        for (std::size_t i = 0; i < r.visibility.size(); ++i)
            if (r.visibility[i] > 0.0f && r.visibility[i] < 1.0f)
                most = std::max(most, r.standardError[i]);
        return most;
    };
    for (auto _ : state) {
        const Reference adaptive =
            traceReference(*s.tracer, s.gbuffer, s.frame.light, ReferenceOptions{});
        ReferenceOptions uniform;
        uniform.adaptive = false;
        Reference all;
        for (uniform.maxRaysPerPixel = 512; uniform.maxRaysPerPixel < (1 << 17);
             uniform.maxRaysPerPixel = uniform.maxRaysPerPixel * 3 / 2 / 16 * 16) {
            all = traceReference(*s.tracer, s.gbuffer, s.frame.light, uniform);
            if (worst(all) <= worst(adaptive)) break;
        }
        state.counters["worst_se"] = worst(adaptive);
        state.counters["uniform_rays_per_pixel"] = uniform.maxRaysPerPixel;
        state.counters["adaptive_over_uniform"] = adaptive.totalRays() / all.totalRays();
    }
}

const auto registered = [] {
    for (const char* id : {"engine", "arcade"}) {
        const std::string scene = id;
        benchmark::RegisterBenchmark(("bare/" + scene).c_str(), bareTraversal, scene)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
        benchmark::RegisterBenchmark(("reference/" + scene).c_str(), reference, scene)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
    }
    for (const char* id : {"fence", "contact"})
        benchmark::RegisterBenchmark((std::string("adaptive_share/") + id).c_str(), adaptiveShare,
                                     std::string(id))
            ->Iterations(1)
            ->Unit(benchmark::kMillisecond);
    return 0;
}();

}  // namespace
}  // namespace penumbra

BENCHMARK_MAIN();
