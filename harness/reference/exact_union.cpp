#include "harness/reference/exact_union.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace penumbra {

namespace {

/// Edges out of order by less than this are not cut at their crossing: what that adds to or takes
/// from the area is less than this times the slab's height. A vertex shared by two edges comes out
/// at x's some ulps apart.
constexpr double kSameX = 1e-13;

/// `less` is asked once for each pair that gets exchanged, and answers true.
template <class Iterator, class Less>
void insertionSort(Iterator begin, Iterator end, const Less& less) {
    for (Iterator i = begin; i != end; ++i) {
        const auto moving = *i;
        Iterator j = i;
        for (; j != begin && less(moving, *(j - 1)); --j) *j = *(j - 1);
        *j = moving;
    }
}

}  // namespace

double UnionSweep::Edge::at(double y) const {
    // Held to its own range, an almost horizontal edge cannot shoot out of the square.
    const double x = x0 + slope * (y - y0);
    return x0 < x1 ? std::clamp(x, x0, x1) : std::clamp(x, x1, x0);
}

void UnionSweep::add(double x0, double y0, double x1, double y1, int rise) {
    if (y0 == y1 || rise == 0) return;
    if (y0 > y1) {
        std::swap(x0, x1);
        std::swap(y0, y1);
        rise = -rise;
    }
    edges_.push_back({x0, y0, x1, y1, (x1 - x0) / (y1 - y0), rise});
}

const std::vector<Strip>& UnionSweep::covered() {
    strips_.clear();
    row_.clear();
    const std::size_t count = edges_.size();
    byStart_.resize(count);
    std::iota(byStart_.begin(), byStart_.end(), 0u);
    std::sort(byStart_.begin(), byStart_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return edges_[a].y0 < edges_[b].y0; });
    ordinates_.clear();
    for (const Edge& edge : edges_) {
        ordinates_.push_back(edge.y0);
        ordinates_.push_back(edge.y1);
    }
    std::sort(ordinates_.begin(), ordinates_.end());
    ordinates_.erase(std::unique(ordinates_.begin(), ordinates_.end()), ordinates_.end());

    std::size_t starting = 0;
    for (std::size_t i = 0; i + 1 < ordinates_.size(); ++i) {
        const double y0 = ordinates_[i];
        std::erase_if(row_, [&](const Crossing& crossing) {
            Edge& edge = edges_[crossing.edge];
            if (edge.y1 > y0) return false;
            bound(edge, 0, y0);
            return true;
        });
        for (; starting < count && edges_[byStart_[starting]].y0 <= y0; ++starting)
            enter(byStart_[starting], y0);
        slab(y0, ordinates_[i + 1]);
    }
    for (const Crossing& crossing : row_) bound(edges_[crossing.edge], 0, ordinates_.back());
    if (!ordinates_.empty()) bound(rightSide_, 0, ordinates_.back());
    return strips_;
}

void UnionSweep::enter(std::uint32_t edge, double y) {
    const double x = edges_[edge].at(y), slope = edges_[edge].slope;
    const auto place = std::find_if(row_.rbegin(), row_.rend(), [&](const Crossing& other) {
        return other.top < x || (other.top == x && edges_[other.edge].slope <= slope);
    });
    row_.insert(place.base(), {x, x, edge});
}

void UnionSweep::slab(double y0, double y1) {
    // The row comes in the order of the slab below, at its top.
    bool isInOrder = true;
    double previous = -1.0;
    for (Crossing& crossing : row_) {
        crossing.bottom = crossing.top;
        crossing.top = edges_[crossing.edge].at(y1);
        isInOrder &= crossing.top >= previous;
        previous = crossing.top;
    }
    int count = 0;
    if (isInOrder) {
        for (const Crossing& crossing : row_) count = pass(crossing, count, y0);
    } else {
        // Edges cross within groups: groups end where all tops so far are below all that follow.
        lowestAbove_.resize(row_.size() + 1);
        lowestAbove_.back() = 2.0;
        for (std::size_t i = row_.size(); i-- > 0;)
            lowestAbove_[i] = std::min(lowestAbove_[i + 1], row_[i].top);
        double highest = -1.0;
        std::size_t first = 0;
        for (std::size_t i = 0; i < row_.size(); ++i) {
            highest = std::max(highest, row_[i].top);
            if (highest > lowestAbove_[i + 1]) continue;
            count = first == i ? pass(row_[i], count, y0)
                               : subdivide(row_.begin() + static_cast<std::ptrdiff_t>(first),
                                           row_.begin() + static_cast<std::ptrdiff_t>(i + 1), count,
                                           y0, y1);
            first = i + 1;
        }
    }
    bound(rightSide_, count > 0 ? 1 : 0, y0);
}

int UnionSweep::pass(const Crossing& crossing, int count, double y) {
    Edge& edge = edges_[crossing.edge];
    const int next = count + edge.rise;
    bound(edge, (count > 0) - (next > 0), y);
    return next;
}

int UnionSweep::subdivide(Row::iterator begin, Row::iterator end, int count, double y0, double y1) {
    part_.assign(begin, end);
    // Sorting by the top what is sorted by the bottom exchanges each crossing pair once.
    cuts_.assign({y0, y1});
    insertionSort(begin, end, [&](const Crossing& moving, const Crossing& passed) {
        if (!(moving.top < passed.top)) return false;
        const double below = moving.bottom - passed.bottom, above = passed.top - moving.top;
        if (below > kSameX && above > kSameX)
            cuts_.push_back(y0 + below / (below + above) * (y1 - y0));
        return true;
    });
    std::sort(cuts_.begin(), cuts_.end());
    int after = count;
    for (std::size_t k = 0; k + 1 < cuts_.size(); ++k) {
        if (!(cuts_[k] < cuts_[k + 1])) continue;
        const double middle = 0.5 * (cuts_[k] + cuts_[k + 1]);
        for (Crossing& crossing : part_) crossing.bottom = edges_[crossing.edge].at(middle);
        insertionSort(part_.begin(), part_.end(),
                      [](const Crossing& a, const Crossing& b) { return a.bottom < b.bottom; });
        after = count;
        for (const Crossing& crossing : part_) after = pass(crossing, after, cuts_[k]);
    }
    return after;
}

void UnionSweep::bound(Edge& edge, int sign, double y) {
    if (edge.sign == sign) return;
    if (edge.sign != 0 && edge.since < y)
        strips_.push_back({edge.since, y, edge.at(edge.since), edge.at(y), edge.sign});
    edge.sign = sign;
    edge.since = y;
}

}  // namespace penumbra
