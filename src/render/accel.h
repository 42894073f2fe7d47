// accel.h — which triangle a ray meets first. The one place that knows Embree (3.13 or 4).
//
// World   rays and hits are in scene coordinates minus center(), so that float rays keep their
//         precision at map coordinates.
// Sides   a hit's normals are turned toward where the ray came from.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "malus/scene/camera.h"
#include "malus/scene/scene.h"
#include "render/lanes.h"

namespace malus {

/// What a ray met, before its place is worked out.
struct Met {
    std::uint32_t placed, triangle;  ///< of Accel, and of the mesh
    float u, v;                      ///< in the triangle
    float distance;                  ///< m
};

/// Points of surfaces as rays find them, side by side. Normals unit, dot(ng, wo) > 0 and
/// dot(n, wo) > 0.
template <class R>
struct HitOf {
    Vector3<R> position;  ///< relative to Accel::center()
    Vector3<R> ng, n;     ///< geometric and shading normal
    R offset;             ///< how far from the surface rays must start, m; leave() uses it

    /// The position moved off the surface to the side of `toward`, so that a ray from there does not
    /// meet the same surface again.
    Vector3<R> leave(const Vector3<R>& toward) const {
        return position + select(dot(ng, toward) < real<R>(0), -offset, offset) * ng;
    }
};
using Hits = HitOf<Reals>;

/// One of them.
struct Hit : HitOf<double> {
    int instance;  ///< index into Scene::instances
    double distance;
};

/// Do rays keep close together? Then Embree follows them as one packet.
enum class Company { kAlone, kClose };

class Accel {
  public:
    explicit Accel(const Scene& scene);
    ~Accel();
    Accel(Accel&&) noexcept;
    Accel& operator=(Accel&&) noexcept;

    const Vec3& center() const;
    /// Radius of a ball around center() that holds the scene, m.
    double radius() const;

    /// First surfaces along unit directions, of the lanes in `active`; nothing for a ray that is not
    /// finite. Returns the lanes that met one.
    unsigned intersect(const RayOf<Reals>& rays, unsigned active, std::array<Met, kSide>& met,
                       Company company = Company::kAlone) const;
    /// The lanes in `active` along whose ray there is any surface.
    unsigned occluded(const RayOf<Reals>& rays, unsigned active,
                      Company company = Company::kAlone) const;
    /// The points met along these directions.
    Hits points(const std::array<Met, kSide>& met, const Vec3s& directions) const;
    /// Index into Scene::instances.
    int instance(const Met& met) const;

    /// The same for a single ray.
    std::optional<Hit> intersect(const Vec3& origin, const Vec3& direction) const;
    bool occluded(const Vec3& origin, const Vec3& direction) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace malus
