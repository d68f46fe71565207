#include "harness/gate/series.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "harness/gate/gated_metric.hpp"

namespace penumbra::gate {
namespace {

using Key = std::tuple<std::string, int, std::string, std::string>;

bool sameMachine(const Approval& a, const Approval& b) {
    return a.renderer == b.renderer && a.threads == b.threads && a.machine == b.machine;
}

/// Half the 95 % interval of the frame time at each approval.
class HalfWidths {
  public:
    HalfWidths(const std::vector<Series>& all, const std::map<Key, std::size_t>& indexOf,
               const Series& of) {
        const auto find = [&](const char* metric) -> const Series* {
            const auto at = indexOf.find({of.scene, of.frame, of.setting, metric});
            return at == indexOf.end() ? nullptr : &all[at->second];
        };
        if (of.metric != "frame_ms") return;
        low_ = find("frame_ms_low");
        high_ = find("frame_ms_high");
    }
    double at(std::size_t approval) const {
        if (!low_ || !high_ || !low_->values[approval] || !high_->values[approval]) return 0.0;
        return 0.5 * (*high_->values[approval] - *low_->values[approval]);
    }

  private:
    const Series *low_ = nullptr, *high_ = nullptr;
};

/// Finds steps in every stretch of approvals without a gap and, for times, of one machine.
void addSteps(Series& series, const GatedMetric& metric, const HalfWidths& widths,
              const std::vector<Approval>& approvals) {
    std::vector<Point> stretch;
    std::size_t begin = 0;
    const auto close = [&] {
        for (Step step : findSteps(stretch, metric.relative, metric.absolute)) {
            step.at += begin;
            series.steps.push_back(step);
        }
        stretch.clear();
    };
    for (std::size_t i = 0; i < approvals.size(); ++i) {
        const bool otherMachine =
            metric.kind == Kind::time && i > 0 && !sameMachine(approvals[i - 1], approvals[i]);
        if (!series.values[i] || otherMachine) close();
        if (!series.values[i]) continue;
        if (stretch.empty()) begin = i;
        stretch.push_back({*series.values[i], widths.at(i)});
    }
    close();
}

}  // namespace

std::vector<Series> seriesOf(const std::vector<Approval>& approvals) {
    std::vector<Series> all;
    std::map<Key, std::size_t> indexOf;
    for (std::size_t i = 0; i < approvals.size(); ++i) {
        if (i > 0)
            for (Series& series : all) series.values[i] = series.values[i - 1];
        for (const Change& c : approvals[i].changes) {
            const auto [at, isNew] =
                indexOf.emplace(Key{c.scene, c.frame, c.setting, c.metric}, all.size());
            if (isNew) {
                all.push_back({c.scene, c.frame, c.setting, c.metric, {}, {}});
                all.back().values.resize(approvals.size());
            }
            all[at->second].values[i] = c.after;
        }
    }
    for (Series& series : all) {
        const auto metric = std::ranges::find(gatedMetrics(), series.metric, &GatedMetric::id);
        if (metric != gatedMetrics().end())
            addSteps(series, *metric, HalfWidths(all, indexOf, series), approvals);
    }
    return all;
}

}  // namespace penumbra::gate
