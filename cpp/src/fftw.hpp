// FFTW's transforms behind owners: the one file pair that knows it.
#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <mutex>
#include <new>
#include <utility>

namespace stiction {

/// What FFTW's widest registers want, and the line of a cache: which instructions a transform takes, and with them its
/// bits, depends on where its numbers begin.
inline constexpr std::size_t alignment = 64;

/// Memory of complex numbers that begins at a line of the cache, grown as needed; what was in it is lost then.
class Room {
 public:
  template <class Real>
  std::complex<Real>* waves(std::size_t count) {
    const std::size_t bytes = count * sizeof(std::complex<Real>);
    if (bytes > bytes_) {
      memory_.reset();
      memory_.reset(static_cast<std::byte*>(::operator new(bytes, std::align_val_t{alignment})));
      bytes_ = bytes;
    }
    return reinterpret_cast<std::complex<Real>*>(memory_.get());
  }

 private:
  struct Release {
    void operator()(std::byte* memory) const { ::operator delete(memory, std::align_val_t{alignment}); }
  };
  std::unique_ptr<std::byte, Release> memory_;
  std::size_t bytes_ = 0;
};

/// Complex transforms of so many numbers, from one aligned place to another, not normalised. Plans are those that FFTW
/// estimates, not those that it measures: the same in every run. Many threads may use one at once, which is planned
/// when first used.
template <class Real>
class Waves {
 public:
  explicit Waves(std::size_t points);
  ~Waves();
  Waves(const Waves&) = delete;
  Waves& operator=(const Waves&) = delete;

  std::size_t points() const { return points_; }
  /// Sums of values times exp(-2πi a b/points).
  void forward(std::complex<Real>* values, std::complex<Real>* waves) const;
  /// Sums of waves times exp(2πi a b/points).
  void back(std::complex<Real>* waves, std::complex<Real>* values) const;

 private:
  std::size_t points_;
  mutable std::once_flag forward_planned_;
  mutable std::once_flag back_planned_;
  mutable void* forward_ = nullptr;
  mutable void* back_ = nullptr;
};

}  // namespace stiction
