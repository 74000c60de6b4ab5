#include "fftw.hpp"

#include <fftw3.h>

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#endif

#include <mutex>
#include <stdexcept>

namespace stiction {
namespace {

std::mutex& unguarded_planner_mutex() {
  static std::mutex mutex;
  return mutex;
}

// FFTW plans may be executed by several threads, but created by only one thread at a time.
std::mutex& planner_mutex() {
#if defined(__unix__) || defined(__APPLE__)
  // Without fork handlers, a child process forked while a plan is created would inherit a locked mutex.
  [[maybe_unused]] static const int fork_handlers =
      pthread_atfork([] { unguarded_planner_mutex().lock(); }, [] { unguarded_planner_mutex().unlock(); },
                     [] { unguarded_planner_mutex().unlock(); });
#endif
  return unguarded_planner_mutex();
}

template <class Real>
struct FftwFunctions;

template <>
struct FftwFunctions<float> {
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
struct FftwFunctions<double> {
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
void* make_plan(std::size_t points, int sign) {
  AlignedBuffer input;
  AlignedBuffer output;
  const std::lock_guard lock(planner_mutex());
  void* plan =
      FftwFunctions<Real>::plan(static_cast<int>(points), input.get<Real>(points), output.get<Real>(points), sign);
  if (plan == nullptr) {
    throw std::runtime_error("ComplexFft: FFTW cannot create a plan for this number of points");
  }
  return plan;
}

}  // namespace

template <class Real>
ComplexFft<Real>::ComplexFft(std::size_t points) : points_(points) {
  if (points == 0 || points > (std::size_t{1} << 30)) {
    throw std::invalid_argument("ComplexFft: points must be between 1 and 2^30");
  }
}

template <class Real>
ComplexFft<Real>::~ComplexFft() {
  const std::lock_guard lock(planner_mutex());
  for (void* plan : {forward_, inverse_}) {
    if (plan != nullptr) {
      FftwFunctions<Real>::destroy(plan);
    }
  }
}

template <class Real>
void ComplexFft<Real>::forward(std::complex<Real>* values, std::complex<Real>* coefficients) const {
  std::call_once(forward_planned_, [&] { forward_ = make_plan<Real>(points_, FFTW_FORWARD); });
  FftwFunctions<Real>::execute(forward_, values, coefficients);
}

template <class Real>
void ComplexFft<Real>::inverse(std::complex<Real>* coefficients, std::complex<Real>* values) const {
  std::call_once(inverse_planned_, [&] { inverse_ = make_plan<Real>(points_, FFTW_BACKWARD); });
  FftwFunctions<Real>::execute(inverse_, coefficients, values);
}

template class ComplexFft<float>;
template class ComplexFft<double>;

}  // namespace stiction
