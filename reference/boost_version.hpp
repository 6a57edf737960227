#pragma once
// Which Boost the closed forms, the fixed steps and the quad-precision runs were computed with.
#include <boost/version.hpp>

namespace odeval::reference {

inline constexpr const char* boost_version = BOOST_LIB_VERSION;

}  // namespace odeval::reference
