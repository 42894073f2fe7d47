// guided_axis.h — ascending nodes with a guide table, so that a search takes constant time on average
// (Chen & Asau, AIIE Trans. 6, 163 (1974)).
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace malus {

class GuidedAxis {
  public:
    GuidedAxis() = default;
    /// At least two nodes.
    explicit GuidedAxis(std::vector<double> nodes);

    /// Largest i with node(i) ≤ x, kept in range.
    std::size_t cell(double x) const { return cell(x, near(x)); }
    /// The same from what near(x) found. Searches for several x wait for memory together when all of
    /// their near() come first.
    std::size_t cell(double x, std::size_t i) const {
        while (i > 0 && nodes_[i] > x) --i;
        while (i + 2 < nodes_.size() && nodes_[i + 1] <= x) ++i;
        return i;
    }
    std::size_t near(double x) const {
        const double g = (x - nodes_.front()) * scale_;
        const double last = static_cast<double>(guide_.size() - 1);
        return guide_[static_cast<std::size_t>(std::clamp(g, 0.0, last))];
    }
    double node(std::size_t i) const { return nodes_[i]; }
    std::size_t cells() const { return nodes_.empty() ? 0 : nodes_.size() - 1; }
    double width(std::size_t i) const { return nodes_[i + 1] - nodes_[i]; }
    /// Where x lies in cell i, brought to [0,1].
    double fraction(std::size_t i, double x) const {
        return std::clamp((x - nodes_[i]) / width(i), 0.0, 1.0);
    }

  private:
    std::vector<double> nodes_;
    std::vector<std::uint32_t> guide_;
    double scale_ = 0;
};

}  // namespace malus
