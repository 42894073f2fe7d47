// embree_traps.cpp — lets a test arm float-exception traps around our code but not inside Embree.
//
// Embree's boxes of no extent and rays parallel to an axis rightly compute ∞·0. The linker sends
// Embree's two ray calls through here (--wrap), where traps rest while Embree works.
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

// Three pointers each, in Embree 3 and 4. The names are the linker's.
extern "C" {
void __real_rtcIntersect1(void*, void*, void*);
void __real_rtcOccluded1(void*, void*, void*);
void __wrap_rtcIntersect1(void*, void*, void*);
void __wrap_rtcOccluded1(void*, void*, void*);

void __wrap_rtcIntersect1(void* a, void* b, void* c) {
    const RestingTraps resting;
    __real_rtcIntersect1(a, b, c);
}
void __wrap_rtcOccluded1(void* a, void* b, void* c) {
    const RestingTraps resting;
    __real_rtcOccluded1(a, b, c);
}
}
