// guided_axis.cpp — the guide table and its use.
// SPDX-License-Identifier: Apache-2.0
#include "malus/scene/guided_axis.h"

namespace malus {

GuidedAxis::GuidedAxis(std::vector<double> nodes) : nodes_(std::move(nodes)) {
    const std::size_t guides = 4 * nodes_.size();
    scale_ = static_cast<double>(guides) / (nodes_.back() - nodes_.front());
    guide_.resize(guides + 1);
    for (std::size_t g = 0; g <= guides; ++g) {
        const double x = nodes_.front() + static_cast<double>(g) / scale_;
        const auto above = std::upper_bound(nodes_.begin(), nodes_.end() - 1, x);
        guide_[g] = static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(
            0, std::min<std::ptrdiff_t>(above - nodes_.begin() - 1, std::ssize(nodes_) - 2)));
    }
}

}  // namespace malus
