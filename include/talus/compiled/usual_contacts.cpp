// The compiled part: functions over lists of contacts with friction and restitution, in double.
#include "talus/solver/usual_contacts.hpp"

namespace talus::detail {

template class contact_list<usual::elastic::round_pair>;
template class contact_list<usual::elastic::round_anchored>;
template class contact_list<usual::elastic::pair_of_tensors>;
template class contact_list<usual::elastic::round_and_tensor>;
template class contact_list<usual::elastic::tensor_and_round>;
template class contact_list<usual::elastic::tensor_anchored>;
template class coloured_list<usual::elastic::round_pair>;
template class coloured_list<usual::elastic::round_anchored>;
template class coloured_list<usual::elastic::pair_of_tensors>;
template class coloured_list<usual::elastic::round_and_tensor>;
template class coloured_list<usual::elastic::tensor_and_round>;
template class coloured_list<usual::elastic::tensor_anchored>;
template class contact_sums<contact_list<usual::elastic::round_pair>, usual::elastic::round_pair>;
template class contact_sums<contact_list<usual::elastic::round_anchored>,
                            usual::elastic::round_anchored>;
template class contact_sums<contact_list<usual::elastic::pair_of_tensors>,
                            usual::elastic::pair_of_tensors>;
template class contact_sums<contact_list<usual::elastic::round_and_tensor>,
                            usual::elastic::round_and_tensor>;
template class contact_sums<contact_list<usual::elastic::tensor_and_round>,
                            usual::elastic::tensor_and_round>;
template class contact_sums<contact_list<usual::elastic::tensor_anchored>,
                            usual::elastic::tensor_anchored>;
template class contact_sums<coloured_list<usual::elastic::round_pair>, usual::elastic::round_pair>;
template class contact_sums<coloured_list<usual::elastic::round_anchored>,
                            usual::elastic::round_anchored>;
template class contact_sums<coloured_list<usual::elastic::pair_of_tensors>,
                            usual::elastic::pair_of_tensors>;
template class contact_sums<coloured_list<usual::elastic::round_and_tensor>,
                            usual::elastic::round_and_tensor>;
template class contact_sums<coloured_list<usual::elastic::tensor_and_round>,
                            usual::elastic::tensor_and_round>;
template class contact_sums<coloured_list<usual::elastic::tensor_anchored>,
                            usual::elastic::tensor_anchored>;

}  // namespace talus::detail
