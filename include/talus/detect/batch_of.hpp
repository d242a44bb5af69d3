#pragma once
// Which pairs of movable bodies of one shape are computed several at a time.

namespace talus::detail {

/// Where `type` is given, pairs of this shape are computed by such batches. One has a `capacity`;
/// the type `place` of what it reads of a body, made by place_of(); set(lane, a, b, margin);
/// search(count), which returns the bits of those pairs that have contacts; uncertain(), the bits
/// of pairs that the function of single pairs has to compute; and collide_lane(a, b, batch, lane,
/// margin, sink) gives the contacts of one pair.
template <class Shape>
struct batch_of {};

template <class Shape>
concept computed_in_batches = requires {
  typename batch_of<Shape>::type;
};

}  // namespace talus::detail
