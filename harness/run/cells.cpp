#include "harness/run/cells.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/gl/context.hpp"
#include "core/gl/work_counter.hpp"
#include "core/sampling/sampling.hpp"
#include "harness/run/gl_state.hpp"
#include "harness/run/statistics.hpp"

namespace penumbra {

void SettingRun::warmUp(const Frame& frame, const Plan& plan, bool keepMaps,
                        const TextureTarget& target, Row& row) {
    resetGlState();
    if (!method_ || !(plan_ == plan)) {
        method_ = setting_.make();
        builtFor_.reset();
        const gl::FencedTimer timer;
        method_->prepare(frame.scene, plan);
        prepareMs_ = timer.stop();
        gl::checkErrors(setting_.name + ": prepare");
        plan_ = plan;
    }
    const LightInputs now{frame.geometry, frame.light, frame.lightBounds};
    kept_ = keepMaps;
    if (kept_ && builtFor_ != now) method_->build(frame, plan_);
    builtFor_ = now;
    target.poison();
    gl::WorkCounter counter;
    if (!kept_) method_->build(frame, plan_);
    method_->shade(frame, plan_, target);
    const gl::Work work = counter.stop();
    gl::checkErrors(setting_.name);
    visibility_ = target.read();

    const WorkCounters own = method_->counters();
    row.prepareMs = prepareMs_;
    row.drawCalls = static_cast<double>(work.drawCalls);
    if (counter.statistics()) {
        row.triangles = static_cast<double>(work.triangles);
        row.fragments = static_cast<double>(work.fragments);
    }
    row.maps = kept_ ? 0.0 : own.maps;
    row.lightTexels = own.lightTexels;
    row.textureMib = own.textureMib;
    row.message = own.message;
}

SettingRun::Sample SettingRun::timed(const Frame& frame, const TextureTarget& target) {
    resetGlState();
    Sample sample;
    if (!kept_) {
        const gl::FencedTimer timer;
        method_->build(frame, plan_);
        sample.buildMs = timer.stop();
    }
    const gl::FencedTimer timer;
    method_->shade(frame, plan_, target);
    sample.shadeMs = timer.stop();
    gl::checkErrors(setting_.name);
    return sample;
}

void runCells(const Frame& frame, const CellOptions& options, const std::vector<SettingRun*>& runs,
              const TextureTarget& target,
              const std::function<void(Row&&, const std::vector<float>&)>& done) {
    struct Cell {
        SettingRun* run;
        std::size_t index;  ///< in `runs`
        Row row;
        std::vector<double> build, shade, total;
        double spentMs = 0.0;  ///< on timed frames
        bool measured(const CellOptions& options) const {
            return total.size() >= kFewestRepeats && spentMs >= options.enoughMs;
        }
    };
    const auto guarded = [&](Cell& cell, const auto& work) {
        try {
            work();
            return true;
        } catch (const Unsupported& e) {
            cell.row.status = "unsupported";
            cell.row.message = e.what();
        } catch (const std::exception& e) {
            cell.row.status = "failed";
            cell.row.message = e.what();
        }
        gl::takeErrors();
        cell.run->forget();
        done(std::move(cell.row), {});
        return false;
    };

    std::vector<Cell> cells;
    for (std::size_t r = 0; r < runs.size(); ++r) {
        SettingRun* const run = runs[r];
        Cell cell{.run = run, .index = r, .row = {}, .build = {}, .shade = {}, .total = {}};
        cell.row.scene = frame.scene.id;
        cell.row.frame = frame.index;
        cell.row.method = run->setting().method;
        cell.row.setting = run->setting().name;
        cell.row.params = run->setting().params;
        cell.row.width = frame.width();
        cell.row.height = frame.height();
        if (guarded(cell, [&] {
                const auto method = run->setting().make();
                const Plan plan =
                    planFor(options.effects, options.calledFor, method->traits().simulates);
                cell.row.effectsSimulated = plan.simulated.text();
                cell.row.effectsSkipped = plan.skipped.text();
                cell.row.effectsMissing = plan.missing.text();
                run->warmUp(frame, plan, options.keepMaps, target, cell.row);
            }))
            cells.push_back(std::move(cell));
    }

    for (int round = 0; round < options.repeats; ++round) {
        std::vector<std::pair<std::uint32_t, std::size_t>> order;
        for (std::size_t i = 0; i < cells.size(); ++i)
            order.emplace_back(
                hash(frame.seed, static_cast<std::uint32_t>(round), static_cast<std::uint32_t>(i)),
                i);
        std::ranges::sort(order);
        for (const auto& [key, i] : order) {
            Cell& cell = cells[i];
            if (!cell.run || cell.measured(options)) continue;
            if (!guarded(cell, [&] {
                    const SettingRun::Sample s = cell.run->timed(frame, target);
                    cell.build.push_back(s.buildMs);
                    cell.shade.push_back(s.shadeMs);
                    cell.total.push_back(s.buildMs + s.shadeMs);
                    cell.spentMs += cell.total.back();
                    if (options.sampled) options.sampled(cell.index, s);
                }))
                cell.run = nullptr;
        }
    }

    for (Cell& cell : cells) {
        if (!cell.run) continue;
        const TimingSummary t = summarise(cell.total, frame.seed);
        cell.row.frameMs = t.median;
        cell.row.frameMsLow = t.low;
        cell.row.frameMsHigh = t.high;
        cell.row.frameMsMad = t.mad;
        cell.row.unstable = t.unstable;
        cell.row.repeats = static_cast<int>(cell.total.size());
        if (!cell.run->kept()) cell.row.buildMs = median(cell.build);
        cell.row.shadeMs = median(cell.shade);
        const std::vector<float>& visibility = cell.run->visibility();
        done(std::move(cell.row), visibility);
    }
}

}  // namespace penumbra
