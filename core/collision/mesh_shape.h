#pragma once
#include <span>
#include <vector>

#include "core/collision/shape.h"
#include "core/pseudo_volume/pseudo_volume.h"

namespace isochor {

/// Any triangle mesh as a rigid shape: the signed distance field of its own pseudo volume, interpolated
/// between voxel centres, so surfaces are exact to a fraction of a voxel. Where the pseudo volume is an
/// envelope about open sheets, the distance is that to its voxels' boundary.
class CollisionMesh final : public CollisionShape {
 public:
  /// Lengths of the field are multiplied by scale. Centred on the centre of mass of the inside voxels, or on
  /// the field's origin. Throws empty_result when no voxel is inside.
  CollisionMesh(const DistanceField& field, const PseudoVolume& pseudo_volume, double scale, bool centered);

  ShapeType type() const override { return ShapeType::mesh; }
  SurfaceQuery query(const Vec3& point) const override;
  std::optional<SweepHit> sweep(const Vec3& from, const Vec3& to) const override;
  Box bounds() const override { return bounds_; }
  double volume() const override { return volume_; }
  Eigen::Matrix3d unit_inertia() const override { return unit_inertia_; }
  std::int64_t bytes() const override {
    return static_cast<std::int64_t>(signed_.capacity() * sizeof(float) + samples_.capacity() * sizeof(Vec3));
  }

  const Vec3& center() const { return center_; }  ///< of this frame in that of the field, scaled
  /// Points on the surface, at most a few thousand, that stand for it against other shapes.
  const std::vector<Vec3>& samples() const { return samples_; }

 private:
  float at(int i, int j, int k) const { return signed_[grid_.index(i, j, k)]; }
  void sign_distances(const DistanceField& field, const PseudoVolume& pseudo_volume, double scale);
  void weigh(const PseudoVolume& pseudo_volume, bool centered);
  void sample(const PseudoVolume& pseudo_volume);
  void thin_samples(std::span<const std::size_t> tips);

  Grid grid_;                  ///< in this shape's frame
  std::vector<float> signed_;  ///< metres, negative inside
  Box bounds_;
  Vec3 center_ = Vec3::Zero();
  double volume_ = 0.0;
  Eigen::Matrix3d unit_inertia_ = Eigen::Matrix3d::Zero();
  std::vector<Vec3> samples_;
};

}  // namespace isochor
