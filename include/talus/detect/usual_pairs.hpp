#pragma once
// The pair functions of the shapes of talus for receivers behind one face: they are in the compiled
// part.
#include "talus/detect/contact_sink.hpp"
#include "talus/detect/narrow.hpp"

#ifdef TALUS_COMPILED
namespace talus {

extern template void collide(const box&, const pose&, const box&, const pose&, real,
                             const detail::contact_sink&);
extern template void collide(const box&, const pose&, const sphere&, const pose&, real,
                             const detail::contact_sink&);
extern template void collide(const capsule&, const pose&, const sphere&, const pose&, real,
                             const detail::contact_sink&);
extern template void collide(const capsule&, const pose&, const capsule&, const pose&, real,
                             const detail::contact_sink&);
extern template void collide(const cylinder&, const pose&, const sphere&, const pose&, real,
                             const detail::contact_sink&);
extern template void collide(const convex_polyhedron&, const pose&, const sphere&, const pose&,
                             real, const detail::contact_sink&);
extern template void collide(const plane&, const pose&, const box&, const pose&, real,
                             const detail::contact_sink&);
extern template void collide_convex(const plane&, const pose&, const capsule&, const pose&, real,
                                    const detail::contact_sink&);
extern template void collide_convex(const plane&, const pose&, const cylinder&, const pose&, real,
                                    const detail::contact_sink&);
extern template void collide_convex(const plane&, const pose&, const convex_polyhedron&,
                                    const pose&, real, const detail::contact_sink&);
extern template void collide_convex(const box&, const pose&, const capsule&, const pose&, real,
                                    const detail::contact_sink&);
extern template void collide_convex(const box&, const pose&, const cylinder&, const pose&, real,
                                    const detail::contact_sink&);
extern template void collide_convex(const box&, const pose&, const convex_polyhedron&, const pose&,
                                    real, const detail::contact_sink&);
extern template void collide_convex(const capsule&, const pose&, const cylinder&, const pose&, real,
                                    const detail::contact_sink&);
extern template void collide_convex(const capsule&, const pose&, const convex_polyhedron&,
                                    const pose&, real, const detail::contact_sink&);
extern template void collide_convex(const cylinder&, const pose&, const cylinder&, const pose&,
                                    real, const detail::contact_sink&);
extern template void collide_convex(const cylinder&, const pose&, const convex_polyhedron&,
                                    const pose&, real, const detail::contact_sink&);
extern template void collide_convex(const convex_polyhedron&, const pose&, const convex_polyhedron&,
                                    const pose&, real, const detail::contact_sink&);
namespace detail {
extern template class box_patches<real>;
extern template class box_batch<real>;
extern template void collide_lane(const box_place<real>&, const box_place<real>&,
                                  const box_batch<real>&, unsigned, real, contact_sink&&);
}  // namespace detail

}  // namespace talus
#endif
