// FFTW transforms and aligned buffers. No other file includes FFTW.
#pragma once

#include "huge_pages.hpp"

#include <complex>
#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <utility>

namespace stiction {

/// Alignment of arrays [bytes]. FFTW chooses instructions by the alignment, which affects the last bits of results.
inline constexpr std::size_t alignment = 64;

/// Growing an AlignedBuffer discards its contents.
class AlignedBuffer {
 public:
  template <class Real>
  std::complex<Real>* get(std::size_t count) {
    const std::size_t bytes = count * sizeof(std::complex<Real>);
    if (bytes > bytes_) {
      memory_.reset();
      memory_.reset(static_cast<std::byte*>(::operator new(bytes, std::align_val_t{alignment})));
      request_huge_pages(memory_.get(), bytes);
      bytes_ = bytes;
    }
    return reinterpret_cast<std::complex<Real>*>(memory_.get());
  }

 private:
  struct Deleter {
    void operator()(std::byte* memory) const { ::operator delete(memory, std::align_val_t{alignment}); }
  };
  std::unique_ptr<std::byte, Deleter> memory_;
  std::size_t bytes_ = 0;
};

/// Plans of FFTW are chosen by estimated costs instead of measured times, so that every run uses the same plans.
/// Plans are created on first use. Several threads may use the same ComplexFft at the same time.
template <class Real>
class ComplexFft {
 public:
  explicit ComplexFft(std::size_t points);
  ~ComplexFft();
  ComplexFft(const ComplexFft&) = delete;
  ComplexFft& operator=(const ComplexFft&) = delete;

  std::size_t points() const { return points_; }
  /// coefficients[b] = Σ_a values[a] exp(-2πi a b/points), without normalisation.
  void forward(std::complex<Real>* values, std::complex<Real>* coefficients) const;
  /// values[b] = Σ_a coefficients[a] exp(2πi a b/points), without normalisation.
  void inverse(std::complex<Real>* coefficients, std::complex<Real>* values) const;

 private:
  std::size_t points_;
  mutable std::once_flag forward_planned_;
  mutable std::once_flag inverse_planned_;
  mutable void* forward_ = nullptr;
  mutable void* inverse_ = nullptr;
};

}  // namespace stiction
