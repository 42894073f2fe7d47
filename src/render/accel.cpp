// accel.cpp — Embree scenes: meshes placed once lie flat in the world, meshes placed more often
// are shared by real instances.
// SPDX-License-Identifier: Apache-2.0
#include "render/accel.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <array>
#include <limits>

#include "malus/core/error.h"

namespace malus {
namespace {

struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct ReleaseGeometry {
    void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<RTCDeviceTy, ReleaseDevice>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, ReleaseScene>;
using Geometry = std::unique_ptr<RTCGeometryTy, ReleaseGeometry>;

void check(RTCDevice device) {
    const RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_OUT_OF_MEMORY)
        throw Error("scene: not enough memory to sort its triangles for ray tracing");
    if (error != RTC_ERROR_NONE)
        throw Error("scene: Embree error " + std::to_string(static_cast<int>(error)) +
                    " while sorting its triangles for ray tracing");
}

EmbreeScene new_scene(RTCDevice device) {
    EmbreeScene scene(rtcNewScene(device));
    rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
    return scene;
}

// Can Embree turn rays into the mesh's own coordinates and back? A node may legally flatten its
// mesh; such a one, and what floats cannot hold, is placed as triangles of its own.
bool invertible(const Affine& a) {
    const double x = length(a.x), y = length(a.y), z = length(a.z);
    const double least = std::min({x, y, z}), most = std::max({x, y, z});
    return least > 1e-15 && most < 1e15 && std::abs(a.determinant()) > 1e-4 * x * y * z;
}

// `positions` must outlive the geometry and be readable 4 bytes past its end.
Geometry triangle_geometry(RTCDevice device, const std::vector<Vec3f>& positions,
                           const Mesh& mesh) {
    Geometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               positions.data(), 0, sizeof(Vec3f), mesh.positions.size());
    rtcSetSharedGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh.triangles.data(), 0, sizeof(mesh.triangles[0]),
                               mesh.triangles.size());
    rtcCommitGeometry(geometry.get());
    return geometry;
}

// Rays side by side, in single precision.
class FloatRays {
  public:
    explicit FloatRays(const RayOf<Reals>& rays) {
        const std::array<const Reals*, 6> numbers{&rays.origin.x,    &rays.origin.y,
                                                  &rays.origin.z,    &rays.direction.x,
                                                  &rays.direction.y, &rays.direction.z};
        Reals most(0.0);
        for (std::size_t k = 0; k < 6; ++k) {
            store_floats(*numbers[k], number_[k].data());
            most = most + abs(*numbers[k]);  // NaN and infinity stay
        }
        finite_ = bits(most < Reals(std::numeric_limits<float>::max()));
    }
    // Debian's Embree has its assertions on: a NaN would end the process.
    bool finite(std::size_t i) const { return finite_ >> i & 1; }
    void fill(RTCRay& ray, std::size_t i) const {
        ray.org_x = number_[0][i], ray.org_y = number_[1][i], ray.org_z = number_[2][i];
        ray.dir_x = number_[3][i], ray.dir_y = number_[4][i], ray.dir_z = number_[5][i];
        ray.tnear = 0;
        ray.tfar = std::numeric_limits<float>::infinity();
        ray.time = 0;
        ray.mask = ~0u;
        ray.id = 0;
        ray.flags = 0;
    }
    // A packet of those in `active`; −1 where one is to be followed.
    template <class Packet>
    std::array<int, kSide> fill(Packet& packet, unsigned active) const {
        float* const to[]{packet.org_x, packet.org_y, packet.org_z,
                          packet.dir_x, packet.dir_y, packet.dir_z};
        for (std::size_t k = 0; k < 6; ++k) std::copy(number_[k].begin(), number_[k].end(), to[k]);
        std::array<int, kSide> valid;
        for (std::size_t i = 0; i < kSide; ++i) {
            valid[i] = (active >> i & 1) && finite(i) ? -1 : 0;
            packet.tnear[i] = 0, packet.tfar[i] = std::numeric_limits<float>::infinity();
            packet.time[i] = 0, packet.mask[i] = ~0u, packet.id[i] = 0, packet.flags[i] = 0;
        }
        return valid;
    }

  private:
    std::array<std::array<float, kSide>, 6> number_;
    unsigned finite_;
};

#if RTC_VERSION_MAJOR >= 4
void embree_intersect(RTCScene scene, RTCRayHit& ray) {
    rtcIntersect1(scene, &ray);
}
void embree_occluded(RTCScene scene, RTCRay& ray) {
    rtcOccluded1(scene, &ray);
}
#else
void embree_intersect(RTCScene scene, RTCRayHit& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, &ray);
}
void embree_occluded(RTCScene scene, RTCRay& ray) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &ray);
}
#endif

// The same for as many rays as are side by side; −1 in `valid` for each to be followed.
template <class Rays>
void follow_packet(RTCScene scene, const int* valid, Rays& rays) {
    constexpr bool kHits = std::is_same_v<Rays, RTCRayHit8> || std::is_same_v<Rays, RTCRayHit4>;
    constexpr bool kEight = std::is_same_v<Rays, RTCRayHit8> || std::is_same_v<Rays, RTCRay8>;
#if RTC_VERSION_MAJOR >= 4
    RTCIntersectArguments with_hits;
    rtcInitIntersectArguments(&with_hits);
    with_hits.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    RTCOccludedArguments without;
    rtcInitOccludedArguments(&without);
    without.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    if constexpr (kHits && kEight) rtcIntersect8(valid, scene, &rays, &with_hits);
    if constexpr (kHits && !kEight) rtcIntersect4(valid, scene, &rays, &with_hits);
    if constexpr (!kHits && kEight) rtcOccluded8(valid, scene, &rays, &without);
    if constexpr (!kHits && !kEight) rtcOccluded4(valid, scene, &rays, &without);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    if constexpr (kHits && kEight) rtcIntersect8(valid, scene, &context, &rays);
    if constexpr (kHits && !kEight) rtcIntersect4(valid, scene, &context, &rays);
    if constexpr (!kHits && kEight) rtcOccluded8(valid, scene, &context, &rays);
    if constexpr (!kHits && !kEight) rtcOccluded4(valid, scene, &context, &rays);
#endif
}

// How far a ray starts off its surface, in units of the farthest coordinate of the triangle it
// leaves: 16 half units in the last place of a float. The hit itself is found in double from the
// triangle's corners, so what must be covered is the rounding of the ray's origin (½ such unit) and
// of Embree's test against corners of that size (a few). Scales with the scene, unlike a constant;
// the idea is Wächter & Binder's, Ray Tracing Gems (2019), ch. 6.
constexpr double kOffset = 0x1p-20;

}  // namespace

// A geometry or an instance of the top scene, by its Embree identifier: where its triangles' points are.
struct Placed {
    int instance = -1;
    bool flat = false;  // its corners already lie in centred world coordinates
    const Vec3f* positions = nullptr;
    const std::array<std::uint32_t, 3>* triangles = nullptr;
    const Vec3f* normals = nullptr;  // null where the mesh has none
    const Affine* to_world = nullptr;
    std::array<Vec3, 3> cofactors;  // columns: of normals
    double reach = 0;  // how far from the mesh's centre the numbers go that a hit is found with, m
};

// A mesh that is placed more than once, in its own coordinates about its own centre: Embree meets
// it there in floats, so that far from the centre they would be too coarse.
struct SharedMesh {
    EmbreeScene scene;
    Vec3 center;
    double radius = 0;  // largest coordinate about the centre
    std::vector<Vec3f> positions;
};

struct Accel::Impl {
    const Scene& scene;
    Vec3 center;
    double radius = 0;
    Device device;
    std::vector<SharedMesh> shared;                  // per mesh; empty where placed once
    std::vector<std::vector<Vec3f>> flat_positions;  // per instance; empty where not flat
    std::vector<Placed> placed;
    EmbreeScene top;

    explicit Impl(const Scene& s) : scene(s), device(rtcNewDevice(nullptr)) {
        if (!device) throw Error("scene: Embree finds no usable processor");
        const Box box = bounds(scene);
        center = box.center();
        radius = length(box.upper - center);
        top = new_scene(device.get());
        build();
        rtcCommitScene(top.get());
        check(device.get());
    }

    void build() {
        std::vector<int> uses(scene.meshes.size(), 0);
        for (const Instance& i : scene.instances)
            if (invertible(i.to_world)) ++uses[static_cast<std::size_t>(i.mesh)];
        shared.resize(scene.meshes.size());
        flat_positions.resize(scene.instances.size());
        for (std::size_t i = 0; i < scene.instances.size(); ++i) {
            const auto mesh = static_cast<std::size_t>(scene.instances[i].mesh);
            const bool flat = uses[mesh] == 1 || !invertible(scene.instances[i].to_world);
            const Geometry geometry = flat ? flat_geometry(i) : instance_geometry(i);
            const unsigned id = rtcAttachGeometry(top.get(), geometry.get());
            if (placed.size() <= id) placed.resize(id + 1);
            placed[id] = place(i, flat);
            check(device.get());
        }
    }

    Geometry flat_geometry(std::size_t i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
        Affine to_center = instance.to_world;
        to_center.t = to_center.t - center;
        std::vector<Vec3f>& positions = flat_positions[i];
        positions.reserve(mesh.positions.size() + 1);
        for (const Vec3f& p : mesh.positions) positions.push_back(Vec3f(to_center.point(Vec3(p))));
        positions.push_back({});  // Embree reads 16 bytes a corner
        return triangle_geometry(device.get(), positions, mesh);
    }

    Geometry instance_geometry(std::size_t i) {
        const Instance& instance = scene.instances[i];
        const auto m = static_cast<std::size_t>(instance.mesh);
        if (!shared[m].scene) share(m);
        Geometry geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_INSTANCE));
        rtcSetGeometryInstancedScene(geometry.get(), shared[m].scene.get());
        const Affine& a = instance.to_world;
        const Vec3 t = a.point(shared[m].center) - center;
        const std::array<Vec3f, 4> columns{Vec3f(a.x), Vec3f(a.y), Vec3f(a.z), Vec3f(t)};
        rtcSetGeometryTransform(geometry.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                                columns.data());
        rtcCommitGeometry(geometry.get());
        return geometry;
    }

    void share(std::size_t m) {
        const Mesh& mesh = scene.meshes[m];
        Box box;
        for (const Vec3f& p : mesh.positions) box.add(Vec3(p));
        const Vec3 half = box.upper - box.center();
        shared[m].center = box.center();
        shared[m].radius = std::max({half.x, half.y, half.z});
        for (const Vec3f& p : mesh.positions)
            shared[m].positions.push_back(Vec3f(Vec3(p) - box.center()));
        shared[m].positions.push_back({});
        shared[m].scene = new_scene(device.get());
        const Geometry geometry = triangle_geometry(device.get(), shared[m].positions, mesh);
        rtcAttachGeometry(shared[m].scene.get(), geometry.get());
        rtcCommitScene(shared[m].scene.get());
    }

    Placed place(std::size_t i, bool flat) const {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[static_cast<std::size_t>(instance.mesh)];
        const Affine& a = instance.to_world;
        Placed at{static_cast<int>(i),
                  flat,
                  flat ? flat_positions[i].data() : mesh.positions.data(),
                  mesh.triangles.data(),
                  mesh.normals.empty() ? nullptr : mesh.normals.data(),
                  &a,
                  {a.normal({1, 0, 0}), a.normal({0, 1, 0}), a.normal({0, 0, 1})}};
        if (!flat)
            at.reach = std::max({length(a.x), length(a.y), length(a.z)}) *
                       shared[static_cast<std::size_t>(instance.mesh)].radius;
        return at;
    }

    template <class RayHits>
    Met met(const RayHits& found, std::size_t i) const {
        const bool instanced = found.hit.instID[0][i] != RTC_INVALID_GEOMETRY_ID;
        return {instanced ? found.hit.instID[0][i] : found.hit.geomID[i], found.hit.primID[i],
                found.hit.u[i], found.hit.v[i], found.ray.tfar[i]};
    }
    Met met(const RTCRayHit& found) const {
        const bool instanced = found.hit.instID[0] != RTC_INVALID_GEOMETRY_ID;
        return {instanced ? found.hit.instID[0] : found.hit.geomID, found.hit.primID, found.hit.u,
                found.hit.v, found.ray.tfar};
    }
};

Accel::Accel(const Scene& scene) : impl_(std::make_unique<Impl>(scene)) {}
Accel::~Accel() = default;
Accel::Accel(Accel&&) noexcept = default;
Accel& Accel::operator=(Accel&&) noexcept = default;

const Vec3& Accel::center() const {
    return impl_->center;
}
double Accel::radius() const {
    return impl_->radius;
}

unsigned Accel::intersect(const RayOf<Reals>& rays, unsigned active, std::array<Met, kSide>& met,
                          Company company) const {
    const FloatRays all(rays);
    unsigned hit = 0;
    if constexpr (kSide == 4 || kSide == 8) {
        if (company == Company::kClose) {
            std::conditional_t<kSide == 8, RTCRayHit8, RTCRayHit4> found;
            alignas(32) const std::array<int, kSide> valid = all.fill(found.ray, active);
            for (std::size_t i = 0; i < kSide; ++i)
                found.hit.geomID[i] = found.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
            follow_packet(impl_->top.get(), valid.data(), found);
            for (std::size_t i = 0; i < kSide; ++i) {
                if (!valid[i] || found.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
                met[i] = impl_->met(found, i);
                hit |= 1u << i;
            }
            return hit;
        }
    }
    for (std::size_t i = 0; i < kSide; ++i) {
        if (!(active >> i & 1) || !all.finite(i)) continue;
        RTCRayHit found;
        all.fill(found.ray, i);
        found.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        found.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        embree_intersect(impl_->top.get(), found);
        if (found.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
        met[i] = impl_->met(found);
        hit |= 1u << i;
    }
    return hit;
}

unsigned Accel::occluded(const RayOf<Reals>& rays, unsigned active, Company company) const {
    const FloatRays all(rays);
    unsigned hidden = 0;
    if constexpr (kSide == 4 || kSide == 8) {
        if (company == Company::kClose) {
            std::conditional_t<kSide == 8, RTCRay8, RTCRay4> packet;
            alignas(32) const std::array<int, kSide> valid = all.fill(packet, active);
            follow_packet(impl_->top.get(), valid.data(), packet);
            for (std::size_t i = 0; i < kSide; ++i)
                if ((active >> i & 1) && (!valid[i] || packet.tfar[i] < 0)) hidden |= 1u << i;
            return hidden;
        }
    }
    for (std::size_t i = 0; i < kSide; ++i) {
        if (!(active >> i & 1)) continue;
        RTCRay ray;
        all.fill(ray, i);
        if (all.finite(i)) embree_occluded(impl_->top.get(), ray);
        if (!all.finite(i) || ray.tfar < 0) hidden |= 1u << i;
    }
    return hidden;
}

// Positions and normals from the triangles' corners in double: what Embree returns of them is
// rounded to float along the whole ray.
Hits Accel::points(const std::array<Met, kSide>& met, const Vec3s& directions) const {
    // [coordinate][lane]; numbers of corners, and of normals up to length: 0 where there is none.
    using Numbers = std::array<std::array<double, kSide>, 3>;
    std::array<Numbers, 3> corners;
    Numbers smooth_normals{};
    std::array<double, kSide> reaches;
    bool any_smooth = false;
    const auto keep = [](const Vec3& v, std::size_t i, Numbers& to) {
        to[0][i] = v.x, to[1][i] = v.y, to[2][i] = v.z;
    };
    for (std::size_t i = 0; i < kSide; ++i) {
        const Placed& at = impl_->placed[met[i].placed];
        const std::array<std::uint32_t, 3>& triangle = at.triangles[met[i].triangle];
        for (std::size_t c = 0; c < 3; ++c) {
            const Vec3 p(at.positions[triangle[c]]);
            keep(at.flat ? p : at.to_world->point(p) - impl_->center, i, corners[c]);
        }
        reaches[i] = at.reach;
        if (!at.normals) continue;
        any_smooth = true;
        const double u = static_cast<double>(met[i].u), v = static_cast<double>(met[i].v);
        const Vec3 n = (1 - u - v) * Vec3(at.normals[triangle[0]]) +
                       u * Vec3(at.normals[triangle[1]]) + v * Vec3(at.normals[triangle[2]]);
        keep(n.x * at.cofactors[0] + n.y * at.cofactors[1] + n.z * at.cofactors[2], i,
             smooth_normals);
    }
    const auto loaded = [](const Numbers& of) {
        return Vec3s{Reals::load_unaligned(of[0].data()), Reals::load_unaligned(of[1].data()),
                     Reals::load_unaligned(of[2].data())};
    };
    const Vec3s p0 = loaded(corners[0]), p1 = loaded(corners[1]), p2 = loaded(corners[2]);
    const Reals u = lanewise<Reals>([&](std::size_t i) { return met[i].u; });
    const Reals v = lanewise<Reals>([&](std::size_t i) { return met[i].v; });

    Hits hit;
    hit.position = p0 + u * (p1 - p0) + v * (p2 - p0);
    const Vec3s outward = cross(p1 - p0, p2 - p0);
    const Reals area = length(outward), zero(0.0), one(1.0);
    Reals reach = Reals::load_unaligned(reaches.data());
    for (const Vec3s* p : {&p0, &p1, &p2})
        reach = max(reach, max(abs(p->x), max(abs(p->y), abs(p->z))));
    hit.offset = Reals(kOffset) * reach;
    // A needle's area can vanish in double; Embree then hits it edge-on at most.
    hit.ng = select(area > zero, outward / select(area > zero, area, one), -directions);
    hit.ng = select(dot(hit.ng, directions) > zero, -hit.ng, hit.ng);
    hit.n = hit.ng;
    if (!any_smooth) return hit;

    const Vec3s smooth = loaded(smooth_normals);
    const Reals norm = length(smooth);
    const auto some = norm > zero;
    const Vec3s n = smooth / select(some, select(dot(smooth, hit.ng) < zero, -norm, norm), one);
    // Near a silhouette a smooth normal can face away from the viewer; the flat one cannot.
    hit.n = select(some && (dot(n, directions) < zero), n, hit.ng);
    return hit;
}

int Accel::instance(const Met& met) const {
    return impl_->placed[met.placed].instance;
}

std::optional<Hit> Accel::intersect(const Vec3& origin, const Vec3& direction) const {
    std::array<Met, kSide> met;
    if (!intersect({Vec3s(origin), Vec3s(direction)}, 1, met)) return std::nullopt;
    met.fill(met[0]);
    const Hits all = points(met, Vec3s(direction));
    const auto first = [](const Vec3s& v) {
        return Vec3{lane(v.x, 0), lane(v.y, 0), lane(v.z, 0)};
    };
    Hit hit;
    hit.position = first(all.position), hit.ng = first(all.ng), hit.n = first(all.n);
    hit.offset = lane(all.offset, 0);
    hit.instance = instance(met[0]);
    hit.distance = static_cast<double>(met[0].distance);
    return hit;
}

bool Accel::occluded(const Vec3& origin, const Vec3& direction) const {
    return occluded({Vec3s(origin), Vec3s(direction)}, 1) != 0;
}

}  // namespace malus
