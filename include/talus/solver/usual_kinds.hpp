#pragma once
// Preparation and relaxation of single contacts of the usual kinds are in the compiled part. For
// what treats few contacts: the loops of solvers do without this header, so that they inline both.
#include "talus/solver/usual_contacts.hpp"

#ifdef TALUS_COMPILED
namespace talus::detail {

extern template class general_contact<usual::elastic::rows, contact_side::tensor,
                                      contact_side::tensor>;
extern template class general_contact<usual::elastic::rows, contact_side::scalar,
                                      contact_side::tensor>;
extern template class general_contact<usual::elastic::rows, contact_side::tensor,
                                      contact_side::scalar>;
extern template class general_contact<usual::elastic::rows, contact_side::tensor,
                                      contact_side::immovable>;
extern template class general_contact<usual::plastic::rows, contact_side::tensor,
                                      contact_side::tensor>;
extern template class general_contact<usual::plastic::rows, contact_side::scalar,
                                      contact_side::tensor>;
extern template class general_contact<usual::plastic::rows, contact_side::tensor,
                                      contact_side::scalar>;
extern template class general_contact<usual::plastic::rows, contact_side::tensor,
                                      contact_side::immovable>;

}  // namespace talus::detail
#endif
