// accel.h — which triangle a ray meets first. The one place that knows Embree (3.13 or 4).
//
// World   rays and hits are in scene coordinates minus center(), so that float rays keep their
//         precision at map coordinates.
// Sides   a hit's normals are turned toward where the ray came from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "malus/scene/scene.h"

namespace malus {

/// A point of a surface as a ray finds it. Normals unit, dot(ng, wo) > 0 and dot(n, wo) > 0.
struct Hit {
    Vec3 position;  ///< relative to Accel::center()
    Vec3 ng, n;     ///< geometric and shading normal
    int instance;   ///< index into Scene::instances
    double distance;
    double offset;  ///< how far from the surface rays must start, m; leave() uses it
};

class Accel {
  public:
    explicit Accel(const Scene& scene);
    ~Accel();
    Accel(Accel&&) noexcept;
    Accel& operator=(Accel&&) noexcept;

    const Vec3& center() const;
    /// Radius of a ball around center() that holds the scene, m.
    double radius() const;

    /// First surface along the unit direction; nothing for a ray that is not finite.
    std::optional<Hit> intersect(const Vec3& origin, const Vec3& direction) const;
    /// Is there any surface along the ray?
    bool occluded(const Vec3& origin, const Vec3& direction) const;

    /// The hit's position moved off its surface to the side of `toward`, so that a ray from there
    /// does not meet the same surface again.
    static Vec3 leave(const Hit& hit, const Vec3& toward);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace malus
