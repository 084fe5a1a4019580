// SPDX-License-Identifier: MIT
#include "bench/measure/gl_times.h"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "bench/measure/bench_clock.h"
#include "renderer/gl/gl.h"

namespace karst::bench {
namespace {

enum Function : std::size_t {
#define KARST_GL_NAME(name) kGl##name,
  KARST_GL_CORE_FUNCTIONS(KARST_GL_NAME)
#undef KARST_GL_NAME
      kFunctions
};

GlCallTimes times[kFunctions] = {
#define KARST_GL_NAME(name) {#name},
    KARST_GL_CORE_FUNCTIONS(KARST_GL_NAME)
#undef KARST_GL_NAME
};

class Stopwatch {
 public:
  explicit Stopwatch(GlCallTimes& time) : time_(time), start_(clock_ms(CLOCK_MONOTONIC)) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() {
    time_.ms += clock_ms(CLOCK_MONOTONIC) - start_;
    ++time_.calls;
  }

 private:
  GlCallTimes& time_;
  double start_;
};

template <std::size_t kFunction, class Call>
struct Timed;
template <std::size_t kFunction, class Result, class... Words>
struct Timed<kFunction, Result (*)(Words...)> {
  static inline Result (*driver)(Words...) = nullptr;
  static Result call(Words... words) {
    const Stopwatch watch(times[kFunction]);
    return driver(words...);
  }
};

}  // namespace

Display::GlFunction TimedDisplay::gl_function(const char* name) const {
  const GlFunction function = display_.gl_function(name);
  if (function == nullptr || std::strncmp(name, "gl", 2) != 0) return function;
#define KARST_GL_TIMED(member)                                         \
  if (std::strcmp(name + 2, #member) == 0) {                           \
    using Call = Timed<kGl##member, decltype(&::gl##member)>;          \
    Call::driver = reinterpret_cast<decltype(Call::driver)>(function); \
    return reinterpret_cast<GlFunction>(&Call::call);                  \
  }
  KARST_GL_CORE_FUNCTIONS(KARST_GL_TIMED)
#undef KARST_GL_TIMED
  return function;
}

void reset_gl_times() {
  for (GlCallTimes& time : times) time.calls = 0, time.ms = 0;
}

std::vector<GlCallTimes> gl_times() {
  std::vector<GlCallTimes> called;
  std::copy_if(std::begin(times), std::end(times), std::back_inserter(called),
               [](const GlCallTimes& time) { return time.calls > 0; });
  std::sort(called.begin(), called.end(),
            [](const GlCallTimes& a, const GlCallTimes& b) { return a.ms > b.ms; });
  return called;
}

}  // namespace karst::bench
