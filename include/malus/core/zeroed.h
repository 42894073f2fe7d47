// zeroed.h — large arrays of zeros that cost nothing before they are used.
//
// std::vector writes its zeros itself, one thread through all of memory. Fresh memory of the system is 0
// as it is and becomes real where it is first touched: by the threads that work on it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>
#include <vector>

namespace malus {

/// For a vector that is given its size once: to shrink and grow it again would bring back old numbers.
template <class T>
struct ZeroedAllocator {
    static_assert(std::is_arithmetic_v<T>);
    using value_type = T;

    ZeroedAllocator() = default;
    template <class U>
    explicit ZeroedAllocator(const ZeroedAllocator<U>&) {}

    T* allocate(std::size_t count) {
        void* memory = std::calloc(count, sizeof(T));
        if (!memory) throw std::bad_alloc();
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t) { std::free(memory); }

    template <class U, class... Value>
    void construct(U* at, Value&&... value) {
        if constexpr (sizeof...(Value) > 0) std::construct_at(at, std::forward<Value>(value)...);
    }

    friend bool operator==(const ZeroedAllocator&, const ZeroedAllocator&) { return true; }
};

template <class T>
using ZeroedVector = std::vector<T, ZeroedAllocator<T>>;

}  // namespace malus
