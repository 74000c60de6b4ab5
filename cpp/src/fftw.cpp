#include "fftw.hpp"

#include <fftw3.h>

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#endif

#include <mutex>
#include <stdexcept>

namespace stiction {
namespace {

// FFTW's planner, unlike what it plans, is for one thread at a time.
std::mutex& planner() {
  static std::mutex mutex;
  return mutex;
}

#if defined(__unix__) || defined(__APPLE__)
// A child that is forked while another thread plans would wait for ever for a lock that no thread of its own holds.
[[maybe_unused]] const int registered =
    pthread_atfork([] { planner().lock(); }, [] { planner().unlock(); }, [] { planner().unlock(); });
#endif

template <class Real>
struct Calls;

template <>
struct Calls<float> {
  using Plan = fftwf_plan;
  static auto plan(int n, std::complex<float>* in, std::complex<float>* out, int sign) {
    return fftwf_plan_dft_1d(n, reinterpret_cast<fftwf_complex*>(in), reinterpret_cast<fftwf_complex*>(out), sign,
                             FFTW_ESTIMATE);
  }
  static void execute(void* plan, std::complex<float>* in, std::complex<float>* out) {
    fftwf_execute_dft(static_cast<Plan>(plan), reinterpret_cast<fftwf_complex*>(in),
                      reinterpret_cast<fftwf_complex*>(out));
  }
  static void destroy(void* plan) { fftwf_destroy_plan(static_cast<Plan>(plan)); }
};

template <>
struct Calls<double> {
  using Plan = fftw_plan;
  static auto plan(int n, std::complex<double>* in, std::complex<double>* out, int sign) {
    return fftw_plan_dft_1d(n, reinterpret_cast<fftw_complex*>(in), reinterpret_cast<fftw_complex*>(out), sign,
                            FFTW_ESTIMATE);
  }
  static void execute(void* plan, std::complex<double>* in, std::complex<double>* out) {
    fftw_execute_dft(static_cast<Plan>(plan), reinterpret_cast<fftw_complex*>(in),
                     reinterpret_cast<fftw_complex*>(out));
  }
  static void destroy(void* plan) { fftw_destroy_plan(static_cast<Plan>(plan)); }
};

template <class Real>
void* planned(std::size_t points, int sign) {
  Room from;
  Room to;
  const std::lock_guard lock(planner());
  void* plan = Calls<Real>::plan(static_cast<int>(points), from.waves<Real>(points), to.waves<Real>(points), sign);
  if (plan == nullptr) {
    throw std::runtime_error("Waves: FFTW has no plan for so many points");
  }
  return plan;
}

}  // namespace

template <class Real>
Waves<Real>::Waves(std::size_t points) : points_(points) {
  if (points == 0 || points > (std::size_t{1} << 30)) {
    throw std::invalid_argument("Waves: points must be from 1 to 2^30");
  }
}

template <class Real>
Waves<Real>::~Waves() {
  const std::lock_guard lock(planner());
  for (void* plan : {forward_, back_}) {
    if (plan != nullptr) {
      Calls<Real>::destroy(plan);
    }
  }
}

template <class Real>
void Waves<Real>::forward(std::complex<Real>* values, std::complex<Real>* waves) const {
  std::call_once(forward_planned_, [&] { forward_ = planned<Real>(points_, FFTW_FORWARD); });
  Calls<Real>::execute(forward_, values, waves);
}

template <class Real>
void Waves<Real>::back(std::complex<Real>* waves, std::complex<Real>* values) const {
  std::call_once(back_planned_, [&] { back_ = planned<Real>(points_, FFTW_BACKWARD); });
  Calls<Real>::execute(back_, waves, values);
}

template class Waves<float>;
template class Waves<double>;

}  // namespace stiction
