#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "core/sampling/sampling.hpp"
#include "harness/run/statistics.hpp"
#include "harness/study/parameter_space.hpp"
#include "harness/study/tune.hpp"

namespace penumbra {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
/// A ladder's climb ends where a frame of the small image takes so long that the full one could
/// only be chosen for want of anything else, milliseconds.
constexpr double kLongestSmallMs = 1500.0;
/// Natural logarithm of how much worse an estimate may be than what is confirmed.
constexpr double kConfirmMargin = 0.25;
constexpr std::size_t kConfirmBatch = 4, kMostConfirmed = 16, kMostWithoutSuccess = 28;
constexpr std::size_t kFinalists = 6;
constexpr int kFinalRepeats = 9;
/// Medians so near are ties where their intervals overlap.
constexpr double kTie = 1.03;

bool isMeasured(const Row& row) {
    return row.status == "ok" && row.metrics.rmse && row.frameMs && row.metrics.nonfinite == 0;
}

/// What a row's frame takes when nobody disturbs it: what neighbours on the machine add to a few
/// repeats must not lose a setting on the way to the final measurement.
double undisturbedMs(const Row& row) {
    return *row.frameMsLow;
}

struct Candidate {
    Setting setting;
    bool rung = false;  ///< of a ladder, or the defaults
    std::optional<Row> small, full;
};

class Search {
  public:
    Search(const TuneGoal& goal, double pixelRatio, std::uint32_t seed, const TuneMeasure& measure)
        : goal_(goal), pixelRatio_(pixelRatio), seed_(seed), measure_(measure) {}

    void climbLadders(const std::vector<std::string>& methods);
    void halve();
    void confirm();
    void decide();
    void checkLadders(const std::vector<std::string>& methods);
    TuneResult take() { return std::move(result_); }

  private:
    /// Logarithms by which a method's full images differ from the estimates.
    struct Correction {
        double rmse = 0.0, ms = 0.0;
        int count = 0;
        double of(double sum) const { return count ? std::exp(sum / count) : 1.0; }
    };

    void run(const std::string& phase, bool fullSize, const std::vector<std::size_t>& which,
             int repeats);
    std::size_t add(const Setting& setting, bool rung);
    bool known(const Setting& setting) const {
        return std::ranges::any_of(
            pool_, [&](const Candidate& c) { return c.setting.name == setting.name; });
    }
    /// Of the full image, from the small one.
    double uncorrectedMs(const Candidate& c) const;
    double estimatedMs(const Candidate& c) const;
    double estimatedRmse(const Candidate& c) const;
    double estimate(const Candidate& c) const {
        return goal_.merit(estimatedRmse(c), estimatedMs(c));
    }
    double confirmed(const Candidate& c) const {
        return goal_.merit(*c.full->metrics.rmse, undisturbedMs(*c.full));
    }
    bool confirmedMeets(const Candidate& c) const {
        return c.full && isMeasured(*c.full) &&
               goal_.meets(*c.full->metrics.rmse, undisturbedMs(*c.full));
    }
    /// Those with a measurement on the small image, best estimate first.
    std::vector<std::size_t> byEstimate() const;
    std::vector<std::size_t> survivors(std::size_t count) const;
    /// The frame time beyond which a setting cannot win.
    double hopelessMs() const;

    const TuneGoal& goal_;
    double pixelRatio_;
    std::uint32_t seed_;
    const TuneMeasure& measure_;
    std::vector<Candidate> pool_;
    std::map<std::string, Correction> corrections_;
    TuneResult result_;
};

std::size_t Search::add(const Setting& setting, bool rung) {
    pool_.push_back({setting, rung, {}, {}});
    return pool_.size() - 1;
}

void Search::run(const std::string& phase, bool fullSize, const std::vector<std::size_t>& which,
                 int repeats) {
    std::vector<Setting> settings;
    for (const std::size_t i : which) settings.push_back(pool_[i].setting);
    const std::vector<Row> rows = measure_(fullSize, settings, repeats);
    for (std::size_t i = 0; i < which.size(); ++i) {
        Candidate& c = pool_[which[i]];
        (fullSize ? c.full : c.small) = rows[i];
        result_.trials.push_back({phase, rows[i]});
    }
}

double Search::uncorrectedMs(const Candidate& c) const {
    const Row& row = *c.small;
    return (row.buildMs.value_or(0.0) + row.shadeMs.value_or(0.0) * pixelRatio_) *
           (undisturbedMs(row) / *row.frameMs);
}

double Search::estimatedMs(const Candidate& c) const {
    const auto at = corrections_.find(c.setting.method);
    return uncorrectedMs(c) * (at == corrections_.end() ? 1.0 : at->second.of(at->second.ms));
}

double Search::estimatedRmse(const Candidate& c) const {
    const auto at = corrections_.find(c.setting.method);
    return *c.small->metrics.rmse *
           (at == corrections_.end() ? 1.0 : at->second.of(at->second.rmse));
}

std::vector<std::size_t> Search::byEstimate() const {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < pool_.size(); ++i)
        if (pool_[i].small && isMeasured(*pool_[i].small)) order.push_back(i);
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return estimate(pool_[i]); });
    return order;
}

std::vector<std::size_t> Search::survivors(std::size_t count) const {
    std::vector<std::size_t> kept;
    std::map<std::string, std::size_t> ofMethod;
    std::map<std::string, bool> methods;
    for (const Candidate& c : pool_) methods[c.setting.method] = true;
    const std::size_t most = methods.size() == 1 ? count : (count + 1) / 2;
    for (const std::size_t i : byEstimate())
        if (kept.size() < count && ofMethod[pool_[i].setting.method]++ < most) kept.push_back(i);
    return kept;
}

double Search::hopelessMs() const {
    if (goal_.maxMs) return 2.0 * *goal_.maxMs;
    double best = kNever;
    for (const Candidate& c : pool_)
        if (c.small && isMeasured(*c.small) && *c.small->metrics.rmse <= *goal_.maxRmse)
            best = std::min(best, estimatedMs(c));
    return 2.0 * best;
}

void Search::climbLadders(const std::vector<std::string>& methods) {
    struct Climb {
        std::vector<Setting> rungs;
        bool on = true;
    };
    std::vector<Climb> climbs;
    std::size_t tallest = 0;
    for (const std::string& method : methods) {
        climbs.push_back({seedSettings(method)});
        tallest = std::max(tallest, climbs.back().rungs.size());
    }
    for (std::size_t rung = 0; rung < tallest; ++rung) {
        std::vector<std::size_t> batch;
        std::vector<Climb*> whose;
        for (Climb& climb : climbs)
            if (climb.on && rung < climb.rungs.size()) {
                batch.push_back(add(climb.rungs[rung], true));
                whose.push_back(&climb);
            }
        if (batch.empty()) return;
        run("ladder", false, batch, 3);
        const double hopeless = hopelessMs();
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const Candidate& c = pool_[batch[i]];
            whose[i]->on = isMeasured(*c.small) && estimatedMs(c) <= hopeless &&
                           *c.small->frameMs <= kLongestSmallMs;
        }
    }
}

void Search::halve() {
    struct Round {
        std::size_t survivors;
        std::uint32_t children;
        int repeats;
    };
    constexpr std::array<Round, 3> kRounds = {{{12, 2, 2}, {6, 3, 3}, {3, 5, 5}}};
    constexpr std::uint32_t kDraws = 6;  // before giving up on another neighbour
    for (std::uint32_t r = 0; r < kRounds.size(); ++r) {
        const Round& round = kRounds[r];
        std::vector<std::size_t> batch = survivors(round.survivors);
        const std::size_t parents = batch.size();
        for (std::uint32_t p = 0; p < parents; ++p)
            for (std::uint32_t child = 0; child < round.children; ++child)
                for (std::uint32_t draw = 0; draw < kDraws; ++draw) {
                    const Setting next = neighbour(pool_[batch[p]].setting,
                                                   hash(seed_, r, p, child * kDraws + draw));
                    if (known(next)) continue;
                    batch.push_back(add(next, false));
                    break;
                }
        run("round " + std::to_string(r + 1), false, batch, round.repeats);
    }
}

void Search::confirm() {
    std::size_t count = 0;
    double best = kNever;
    const auto batchOf = [&](auto&& wanted, std::size_t most) {
        std::vector<std::size_t> batch;
        for (const std::size_t i : byEstimate())
            if (!pool_[i].full && batch.size() < most && wanted(pool_[i])) batch.push_back(i);
        return batch;
    };
    const auto take = [&](const std::vector<std::size_t>& batch) {
        run("confirm", true, batch, 3);
        for (const std::size_t i : batch) {
            const Candidate& c = pool_[i];
            if (!isMeasured(*c.full)) continue;
            if (confirmedMeets(c)) best = std::min(best, confirmed(c));
            Correction& correction = corrections_[c.setting.method];
            const double ms = uncorrectedMs(c);
            if (!(*c.small->metrics.rmse > 0.0) || !(*c.full->metrics.rmse > 0.0) || !(ms > 0.0))
                continue;
            correction.rmse += std::log(*c.full->metrics.rmse / *c.small->metrics.rmse);
            correction.ms += std::log(undisturbedMs(*c.full) / ms);
            ++correction.count;
        }
        count += batch.size();
    };
    take(batchOf([](const Candidate& c) { return c.rung; }, 2));
    while (count < (best < kNever ? kMostConfirmed : kMostWithoutSuccess)) {
        const auto batch =
            batchOf([&](const Candidate& c) { return estimate(c) <= best + kConfirmMargin; },
                    kConfirmBatch);
        if (batch.empty()) return;
        take(batch);
    }
}

void Search::decide() {
    std::vector<std::size_t> finalists;
    for (std::size_t i = 0; i < pool_.size(); ++i)
        if (confirmedMeets(pool_[i])) finalists.push_back(i);
    std::ranges::stable_sort(finalists, {}, [&](std::size_t i) { return confirmed(pool_[i]); });
    if (goal_.maxMs && finalists.size() > kFinalists) {
        // The most accurate may miss the limit when measured again: the fastest is kept too.
        const auto fastest = std::ranges::min_element(
            finalists, {}, [&](std::size_t i) { return undisturbedMs(*pool_[i].full); });
        std::swap(finalists[kFinalists - 1],
                  fastest - finalists.begin() < static_cast<std::ptrdiff_t>(kFinalists)
                      ? finalists[kFinalists - 1]
                      : *fastest);
    }
    finalists.resize(std::min(finalists.size(), kFinalists));
    if (!finalists.empty()) run("final", true, finalists, kFinalRepeats);
    // What was optimism so far is held against the median now.
    const auto keepMeeting = [&] {
        std::erase_if(finalists, [&](std::size_t i) {
            const Row& r = *pool_[i].full;
            return !isMeasured(r) || !goal_.meets(*r.metrics.rmse, *r.frameMs);
        });
    };
    keepMeeting();
    // Where the machine was too busy for all of them, those follow that leave more room.
    for (const double share : {0.7, 0.4, 0.1}) {
        if (!finalists.empty() || !goal_.maxMs) break;
        for (const std::size_t i : byEstimate())
            if (finalists.size() < kFinalists && estimatedMs(pool_[i]) <= share * *goal_.maxMs)
                finalists.push_back(i);
        if (!finalists.empty()) run("final", true, finalists, kFinalRepeats);
        keepMeeting();
    }

    if (finalists.empty()) {
        const auto misses = [&](const Row& r) {
            return goal_.maxMs ? *r.frameMs : *r.metrics.rmse;
        };
        for (const auto member : {&Candidate::full, &Candidate::small}) {
            for (const Candidate& c : pool_) {
                const std::optional<Row>& at = c.*member;
                if (at && isMeasured(*at) &&
                    (!result_.nearest || misses(*at) < misses(*result_.nearest)))
                    result_.nearest = at;
            }
            if (result_.nearest) return;
        }
        return;
    }
    const auto row = [&](std::size_t i) -> const Row& { return *pool_[i].full; };
    std::ranges::stable_sort(finalists, {}, [&](std::size_t i) {
        return goal_.merit(*row(i).metrics.rmse, *row(i).frameMs);
    });
    const Row& first = row(finalists.front());
    const auto ties = [&](std::size_t i) {
        return goal_.maxMs ? *row(i).metrics.rmse == *first.metrics.rmse
                           : *row(i).frameMs <= kTie * *first.frameMs &&
                                 *row(i).frameMsLow <= *first.frameMsHigh;
    };
    std::erase_if(finalists, [&](std::size_t i) { return !ties(i); });
    result_.best = row(*std::ranges::min_element(finalists, {}, [&](std::size_t i) {
        return std::tuple(*row(i).metrics.rmse, spelled(pool_[i].setting));
    }));
}

void Search::checkLadders(const std::vector<std::string>& methods) {
    if (!result_.best) return;
    // Far beyond what could win: estimates from few repeats are a few times too high at worst.
    const double mostMs = 6.0 * goal_.maxMs.value_or(*result_.best->frameMs);
    std::vector<Setting> settings;
    for (const std::string& method : methods)
        for (const Setting& rung : seedSettings(method)) {
            const auto at = std::ranges::find_if(
                pool_, [&](const Candidate& c) { return c.setting.name == rung.name; });
            // A rung that was not even climbed costs more than the one below it, which was too
            // dear.
            if (at != pool_.end() && at->small && isMeasured(*at->small) &&
                estimatedMs(*at) <= mostMs)
                settings.push_back(rung);
        }
    const auto isFound = [&](const Setting& s) { return s.name == result_.best->setting; };
    if (std::ranges::none_of(settings, isFound))
        settings.push_back(std::ranges::find_if(pool_, isFound, &Candidate::setting)->setting);
    const std::vector<Row> rows = measure_(true, settings, kFinalRepeats);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Row& row = rows[i];
        result_.trials.push_back({"check", row});
        if (!isMeasured(row)) continue;
        if (isFound(settings[i])) result_.besideLadder = row;
        const std::vector<Setting> seeds = seedSettings(row.method);
        const bool isRung = std::ranges::find(seeds, row.setting, &Setting::name) != seeds.end();
        if (isRung && goal_.meets(*row.metrics.rmse, *row.frameMs) &&
            (!result_.ladderBest ||
             goal_.merit(*row.metrics.rmse, *row.frameMs) <
                 goal_.merit(*result_.ladderBest->metrics.rmse, *result_.ladderBest->frameMs)))
            result_.ladderBest = row;
    }
    if (!result_.ladderBest || !result_.besideLadder) return;
    const Row &found = *result_.besideLadder, &ladder = *result_.ladderBest;
    result_.atLeastAsGood = goal_.maxMs ? *found.metrics.rmse <= *ladder.metrics.rmse
                                        : *found.frameMsLow <= *ladder.frameMsHigh;
}

}  // namespace

double TuneGoal::merit(double rmse, double ms) const {
    constexpr double kPenalty = 8.0;
    const double small = std::log(std::max(maxMs ? rmse : ms, 1e-9));
    const double over = maxMs ? ms / *maxMs : rmse / *maxRmse;
    return small + kPenalty * std::max(0.0, std::log(std::max(over, 1e-9)));
}

TuneResult searchSettings(const std::vector<std::string>& methods, const TuneGoal& goal,
                          double pixelRatio, std::uint32_t seed, bool againstLadders,
                          const TuneMeasure& measure) {
    Search search(goal, pixelRatio, seed, measure);
    search.climbLadders(methods);
    search.halve();
    search.confirm();
    search.decide();
    if (againstLadders) search.checkLadders(methods);
    return search.take();
}

}  // namespace penumbra
