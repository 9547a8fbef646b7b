#pragma once

namespace isochor {

/// Tells the front's thread that something changed: a job ended, a frame came, an answer is ready. Any thread
/// may wake; wakes that meet become one.
class Waker {
 public:
  Waker();
  ~Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  void wake() const;
  void clear() const;
  int descriptor() const { return descriptor_; }

 private:
  int descriptor_;
};

}  // namespace isochor
