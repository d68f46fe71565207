#include "harness/viewer/progressive_reference.hpp"

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "harness/metrics/error_sums.hpp"

namespace penumbra {
namespace {

/// Thrown out of a progress callback, which ends tracing.
struct Abandoned {};

std::optional<double> penumbraError(const Reference& reference, const GBuffer& gbuffer) {
    const std::vector<LightClass> classes = classifyLight(reference, gbuffer);
    ErrorSums sums;
    for (std::size_t i = 0; i < classes.size(); ++i)
        if (classes[i] == LightClass::penumbra) sums.add(reference.standardError[i]);
    return sums.rms();
}

}  // namespace

Reference meanOf(const std::vector<Reference>& passes) {
    Reference mean = passes.front();
    const auto count = static_cast<double>(passes.size());
    for (std::size_t i = 0; i < mean.visibility.size(); ++i) {
        double visibility = 0.0, irradiance = 0.0, rays = 0.0, variance = 0.0;
        bool constant = true;
        for (const Reference& pass : passes) {
            visibility += pass.visibility[i];
            irradiance += pass.irradiance[i];
            rays += pass.rays[i];
            variance += static_cast<double>(pass.standardError[i]) * pass.standardError[i];
            constant = constant && pass.visibility[i] == mean.visibility[i];
        }
        constant = constant && (mean.visibility[i] == 0.0f || mean.visibility[i] == 1.0f);
        mean.visibility[i] = static_cast<float>(visibility / count);
        mean.irradiance[i] = static_cast<float>(irradiance / count);
        mean.rays[i] = static_cast<float>(rays);
        // All rays agree: the zero-count bound of all of them (reference.hpp).
        const double error = constant && rays > 0.0 ? 3.0 / rays : std::sqrt(variance) / count;
        if (variance > 0.0) mean.standardError[i] = static_cast<float>(error);
    }
    return mean;
}

ProgressiveReference::ProgressiveReference(const TruthOptions& options)
    : options_(options), worker_([this] { work(); }) {}

ProgressiveReference::~ProgressiveReference() {
    {
        const std::scoped_lock lock(mutex_);
        ending_ = true;
        ++number_;
    }
    changed_.notify_one();
    worker_.join();
}

void ProgressiveReference::ask(Question question) {
    {
        const std::scoped_lock lock(mutex_);
        question_ = std::move(question);
        ++number_;
        latest_.reset();
        error_.clear();
        progress_ = 0.0;
    }
    changed_.notify_one();
}

void ProgressiveReference::stop() {
    const std::scoped_lock lock(mutex_);
    question_.reset();
    ++number_;
    latest_.reset();
    error_.clear();
    progress_ = 1.0;
}

std::shared_ptr<const ProgressiveReference::Estimate> ProgressiveReference::latest() const {
    const std::scoped_lock lock(mutex_);
    return latest_;
}

double ProgressiveReference::progress() const {
    const std::scoped_lock lock(mutex_);
    return progress_;
}

std::string ProgressiveReference::error() const {
    const std::scoped_lock lock(mutex_);
    return error_;
}

void ProgressiveReference::work() {
    tbb::task_arena arena(options_.threadCount());
    for (;;) {
        Question question;
        std::uint64_t number = 0;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return ending_ || question_; });
            if (ending_) return;
            question = *std::move(question_);
            question_.reset();
            number = number_;
        }
        std::string error;
        try {
            arena.execute([&] { answer(question, number); });
        } catch (const Abandoned&) {
        } catch (const std::exception& e) {
            error = e.what();
        }
        const std::scoped_lock lock(mutex_);
        if (number != number_) continue;
        error_ = error;
        progress_ = 1.0;
    }
}

void ProgressiveReference::publish(std::uint64_t number, Estimate estimate) {
    estimate.standardError = penumbraError(estimate.reference, *estimate.gbuffer);
    const std::scoped_lock lock(mutex_);
    if (number != number_) throw Abandoned();
    latest_ = std::make_shared<const Estimate>(std::move(estimate));
    progress_ = 0.0;
}

void ProgressiveReference::answer(const Question& question, std::uint64_t number) {
    const Progress progress = [&](double fraction) {
        const std::scoped_lock lock(mutex_);
        if (number != number_) throw Abandoned();
        progress_ = fraction;
    };
    const auto trace = [&](ReferenceOptions options) {
        return traceReference(*question.tracer, *question.gbuffer, question.light, options,
                              progress);
    };
    ReferenceOptions options;
    options.seed = options_.seed;
    if (question.light.isPoint()) {
        publish(number, {question.gbuffer, trace(options), "one ray per pixel", {}, true});
        return;
    }
    options.adaptive = false;
    for (const int rays : {16, 64}) {
        options.maxRaysPerPixel = rays;
        publish(
            number,
            {question.gbuffer, trace(options), fmt::format("{} rays per pixel", rays), {}, false});
    }
    options = {};
    options.seed = options_.seed;
    for (const double target : {1.0 / 64, 1.0 / 256}) {
        if (target <= options_.referenceSe) break;
        options.targetStandardError = target;
        publish(number, {question.gbuffer,
                         trace(options),
                         fmt::format("adaptive to 1/{:.0f}", 1.0 / target),
                         {},
                         false});
    }
    options.targetStandardError = options_.referenceSe;
    const bool exact = options_.reference == "exact";
    std::vector<Reference> passes;
    passes.push_back(exact || question.cached
                         ? obtainReference(*question.scene, question.index, *question.tracer,
                                           *question.gbuffer, question.light, options_, progress)
                               .reference
                         : trace(options));
    publish(number, {question.gbuffer,
                     passes.front(),
                     exact ? "exact" : fmt::format("adaptive to {:.2g}", options_.referenceSe),
                     {},
                     true});
    while (!exact && passes.size() < kMostPasses) {
        // Far from the seeds that a user counts up.
        options.seed = options_.seed + 0x10001u * static_cast<std::uint32_t>(passes.size());
        passes.push_back(trace(options));
        publish(number, {question.gbuffer,
                         meanOf(passes),
                         fmt::format("mean of {} at {:.2g}", passes.size(), options_.referenceSe),
                         {},
                         true});
    }
}

}  // namespace penumbra
