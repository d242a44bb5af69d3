// The compiled part: contact points of the shapes of talus.
#include "talus/detect/usual_pairs.hpp"

namespace talus {

template void collide(const box&, const pose&, const box&, const pose&, real,
                      const detail::contact_sink&);
template void collide(const box&, const pose&, const sphere&, const pose&, real,
                      const detail::contact_sink&);
template void collide(const capsule&, const pose&, const sphere&, const pose&, real,
                      const detail::contact_sink&);
template void collide(const capsule&, const pose&, const capsule&, const pose&, real,
                      const detail::contact_sink&);
template void collide(const cylinder&, const pose&, const sphere&, const pose&, real,
                      const detail::contact_sink&);
template void collide(const convex_polyhedron&, const pose&, const sphere&, const pose&, real,
                      const detail::contact_sink&);
template void collide(const plane&, const pose&, const box&, const pose&, real,
                      const detail::contact_sink&);
template void collide_convex(const plane&, const pose&, const capsule&, const pose&, real,
                             const detail::contact_sink&);
template void collide_convex(const plane&, const pose&, const cylinder&, const pose&, real,
                             const detail::contact_sink&);
template void collide_convex(const plane&, const pose&, const convex_polyhedron&, const pose&, real,
                             const detail::contact_sink&);
template void collide_convex(const box&, const pose&, const capsule&, const pose&, real,
                             const detail::contact_sink&);
template void collide_convex(const box&, const pose&, const cylinder&, const pose&, real,
                             const detail::contact_sink&);
template void collide_convex(const box&, const pose&, const convex_polyhedron&, const pose&, real,
                             const detail::contact_sink&);
template void collide_convex(const capsule&, const pose&, const cylinder&, const pose&, real,
                             const detail::contact_sink&);
template void collide_convex(const capsule&, const pose&, const convex_polyhedron&, const pose&,
                             real, const detail::contact_sink&);
template void collide_convex(const cylinder&, const pose&, const cylinder&, const pose&, real,
                             const detail::contact_sink&);
template void collide_convex(const cylinder&, const pose&, const convex_polyhedron&, const pose&,
                             real, const detail::contact_sink&);
template void collide_convex(const convex_polyhedron&, const pose&, const convex_polyhedron&,
                             const pose&, real, const detail::contact_sink&);
namespace detail {
template class box_patches<real>;
template class box_batch<real>;
template void collide_lane(const box_place<real>&, const box_place<real>&, const box_batch<real>&,
                           unsigned, real, contact_sink&&);
}  // namespace detail

}  // namespace talus
