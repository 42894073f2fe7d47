// embree_traps.cpp — lets a test arm float-exception traps around our code but not inside Embree.
//
// Embree's boxes of no extent and rays parallel to an axis rightly compute ∞·0. The linker sends
// Embree's ray calls through here (--wrap), where traps rest while Embree works.
// SPDX-License-Identifier: Apache-2.0
#include <cfenv>

namespace {

class RestingTraps {
  public:
    RestingTraps() : armed_(::fegetexcept()) {
        if (armed_) ::fedisableexcept(FE_ALL_EXCEPT);
    }
    ~RestingTraps() {
        if (!armed_) return;
        std::feclearexcept(FE_ALL_EXCEPT);
        ::feenableexcept(armed_);
    }
    RestingTraps(const RestingTraps&) = delete;
    RestingTraps& operator=(const RestingTraps&) = delete;

  private:
    int armed_;
};

}  // namespace

// Three pointers to one ray, four to a packet, in Embree 3 and 4. The names are the linker's.
#define MALUS_TRAPS_REST_ALONE(name)                \
    void __real_##name(void*, void*, void*);        \
    void __wrap_##name(void*, void*, void*);        \
    void __wrap_##name(void* a, void* b, void* c) { \
        const RestingTraps resting;                 \
        __real_##name(a, b, c);                     \
    }
#define MALUS_TRAPS_REST_IN_PACKET(name)                     \
    void __real_##name(void*, void*, void*, void*);          \
    void __wrap_##name(void*, void*, void*, void*);          \
    void __wrap_##name(void* a, void* b, void* c, void* d) { \
        const RestingTraps resting;                          \
        __real_##name(a, b, c, d);                           \
    }
extern "C" {
MALUS_TRAPS_REST_ALONE(rtcIntersect1)
MALUS_TRAPS_REST_ALONE(rtcOccluded1)
MALUS_TRAPS_REST_IN_PACKET(rtcIntersect4)
MALUS_TRAPS_REST_IN_PACKET(rtcOccluded4)
MALUS_TRAPS_REST_IN_PACKET(rtcIntersect8)
MALUS_TRAPS_REST_IN_PACKET(rtcOccluded8)
}
