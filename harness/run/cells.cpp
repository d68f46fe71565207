#include "harness/run/cells.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/gl/context.hpp"
#include "core/gl/work_counter.hpp"
#include "core/sampling/sampling.hpp"
#include "harness/run/gl_state.hpp"
#include "harness/run/statistics.hpp"

namespace penumbra {

bool keepsMaps(const Plan& plan, int index) {
    return index > 0 && !plan.has(Effect::moving_light) && !plan.has(Effect::moving_casters);
}

void SettingRun::prepareFor(const Frame& frame, const Plan& plan) {
    resetGlState();
    if (method_ && plan_ == plan) return;
    method_ = setting_.make();
    builtFor_.reset();
    const gl::FencedTimer timer;
    method_->prepare(frame.scene, plan);
    prepareMs_ = timer.stop();
    gl::checkErrors(setting_.name + ": prepare");
    plan_ = plan;
}

void SettingRun::warmUp(const Frame& frame, const Plan& plan, bool keepMaps,
                        const TextureTarget& target, Row& row) {
    prepareFor(frame, plan);
    const LightInputs now{frame.geometry, frame.light, frame.lightBounds, frame.casterFacts};
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
    row.maps = kept_ ? own.shadeMaps : own.maps;
    row.lightTexels = own.lightTexels;
    row.textureMib = own.textureMib;
    row.message = own.message;
}

void SettingRun::forgetCamera() {
    if (kept_ && plan_.has(Effect::moving_camera)) method_->forgetCamera();
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

SettingRun::Sample SettingRun::live(const Frame& frame, const Plan& plan,
                                    const TextureTarget& target) {
    prepareFor(frame, plan);
    const LightInputs now{frame.geometry, frame.light, frame.lightBounds, frame.casterFacts};
    kept_ = builtFor_ == now;
    builtFor_ = now;
    target.poison();
    const Sample sample = timed(frame, target);
    visibility_ = target.read();
    return sample;
}

void runCells(const Frame& frame, const CellOptions& options, const std::vector<SettingRun*>& runs,
              const TextureTarget& target,
              const std::function<void(std::size_t, Row&&, const std::vector<float>&)>& done) {
    struct Cell {
        SettingRun* run = nullptr;
        std::size_t index = 0;  ///< in `runs`
        Row row;
        const Frame* frame = nullptr;  ///< as its plan has it
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
        } catch (...) {
            cell.row.status = "failed";
            cell.row.message = "threw something that is no std::exception";
        }
        gl::takeErrors();
        cell.run->forget();
        done(cell.index, std::move(cell.row), {});
        return false;
    };

    std::vector<Cell> cells;
    for (std::size_t r = 0; r < runs.size() && !(options.stop && options.stop()); ++r) {
        SettingRun* const run = runs[r];
        Cell cell;
        cell.run = run;
        cell.index = r;
        cell.row.scene = frame.scene.id;
        cell.row.frame = frame.index;
        cell.row.method = run->setting().method;
        cell.row.setting = run->setting().name;
        cell.row.params = run->setting().params;
        cell.row.width = frame.width();
        cell.row.height = frame.height();
        if (guarded(cell, [&] {
                const auto method = run->setting().make();
                const Plan plan = planFor(run->effects().value_or(options.effects),
                                          options.calledFor, method->traits().simulates);
                cell.frame = options.frameFor ? &options.frameFor(plan) : &frame;
                cell.row.effectsSimulated = plan.simulated.text();
                cell.row.effectsSkipped = plan.skipped.text();
                cell.row.effectsMissing = plan.missing.text();
                run->warmUp(*cell.frame, plan, keepsMaps(plan, frame.index), target, cell.row);
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
                    cell.run->forgetCamera();
                    const SettingRun::Sample s = cell.run->timed(*cell.frame, target);
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
        done(cell.index, std::move(cell.row), visibility);
    }
}

}  // namespace penumbra
