// Lanes as a struct of two registers (AVX2) or four (SSE, NEON), with its operators.
//
// Not one vector of 64 bytes: compilers keep vectors wider than a register in memory and shuffle
// them lane by lane. Registers as members of a struct stay registers.
#pragma once

#include <cstdint>
#include <type_traits>
#include <utility>

namespace r3gw {

#if defined(__AVX2__)
constexpr int kPartLanes = 8;
#else
constexpr int kPartLanes = 4;
#endif
constexpr int kParts = kLanes / kPartLanes;

// One register.
template <class T>
struct PartOf;
template <>
struct PartOf<float> {
  using Type = float __attribute__((vector_size(4 * kPartLanes)));
};
template <>
struct PartOf<std::int32_t> {
  using Type = std::int32_t __attribute__((vector_size(4 * kPartLanes)));
};
template <class T>
using Part = typename PartOf<T>::Type;

template <class T>
struct Split {
  Part<T> part[kParts];
  T operator[](int lane) const { return part[lane / kPartLanes][lane % kPartLanes]; }
};

using Lanes = Split<float>;
using IntLanes = Split<std::int32_t>;
using Mask = IntLanes;  // All ones where true.

// Calls make(i) with every register's number as a constant; what it returns are the registers.
template <class T, class Make, int... I>
R3GW_INLINE constexpr Split<T> each_part(const Make& make, std::integer_sequence<int, I...>) {
  return {{make(std::integral_constant<int, I>{})...}};
}
template <class T, class Make>
R3GW_INLINE constexpr Split<T> each_part(const Make& make) {
  return each_part<T>(make, std::make_integer_sequence<int, kParts>{});
}
template <class T, class Make, int... Lane>
R3GW_INLINE constexpr Part<T> each_lane(const Make& make, std::integer_sequence<int, Lane...>) {
  return Part<T>{make(std::integral_constant<int, Lane>{})...};
}
// Calls make(lane) with every lane's number as a constant.
template <class T, class Make>
R3GW_INLINE constexpr Split<T> by_lane(const Make& make) {
  return each_part<T>([&](auto i) {
    constexpr int kFirst = decltype(i)::value * kPartLanes;
    return each_lane<T>(
        [&](auto lane) { return make(std::integral_constant<int, kFirst + lane>{}); },
        std::make_integer_sequence<int, kPartLanes>{});
  });
}

#define R3GW_BY_PARTS(Result, Operator)                                                     \
  template <class T>                                                                        \
  R3GW_INLINE Split<Result> operator Operator(Split<T> a, Split<T> b) {                     \
    return each_part<Result>([&](auto i) { return a.part[i] Operator b.part[i]; });         \
  }                                                                                         \
  template <class T>                                                                        \
  R3GW_INLINE Split<Result> operator Operator(Split<T> a, std::type_identity_t<T> b) {      \
    return each_part<Result>([&](auto i) { return a.part[i] Operator b; });                 \
  }                                                                                         \
  template <class T>                                                                        \
  R3GW_INLINE Split<Result> operator Operator(std::type_identity_t<T> a, Split<T> b) {      \
    return each_part<Result>([&](auto i) { return a Operator b.part[i]; });                 \
  }
#define R3GW_BY_PARTS_IN_PLACE(Operator)                                                    \
  R3GW_BY_PARTS(T, Operator)                                                                \
  template <class T, class Other>                                                           \
  R3GW_INLINE Split<T>& operator Operator##=(Split<T>& a, Other b) {                        \
    return a = a Operator b;                                                                \
  }
R3GW_BY_PARTS_IN_PLACE(+)
R3GW_BY_PARTS_IN_PLACE(-)
R3GW_BY_PARTS_IN_PLACE(*)
R3GW_BY_PARTS_IN_PLACE(/)
R3GW_BY_PARTS_IN_PLACE(&)
R3GW_BY_PARTS_IN_PLACE(|)
R3GW_BY_PARTS(T, %)
R3GW_BY_PARTS(T, <<)
R3GW_BY_PARTS(T, >>)
R3GW_BY_PARTS(std::int32_t, <)
R3GW_BY_PARTS(std::int32_t, >)
R3GW_BY_PARTS(std::int32_t, >=)
R3GW_BY_PARTS(std::int32_t, !=)
R3GW_BY_PARTS(std::int32_t, ==)
#undef R3GW_BY_PARTS_IN_PLACE
#undef R3GW_BY_PARTS

template <class T>
R3GW_INLINE Split<T> operator-(Split<T> a) {
  return each_part<T>([&](auto i) { return -a.part[i]; });
}
R3GW_INLINE IntLanes operator~(IntLanes a) {
  return each_part<std::int32_t>([&](auto i) { return ~a.part[i]; });
}

}  // namespace r3gw
