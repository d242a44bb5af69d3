#pragma once
// A receiver of contact points behind one face: a pair function is compiled once, not for each
// receiver.
#include <type_traits>

#include "talus/contact/contact_geometry.hpp"

namespace talus::detail {

/// Refers to a callable that takes a contact_geometry, and must not outlive it.
class contact_sink {
 public:
  template <class Sink>
  requires(!std::is_same_v<std::remove_cvref_t<Sink>, contact_sink>) explicit contact_sink(
      Sink& sink)
      : sink_(const_cast<std::remove_const_t<Sink>*>(&sink)),
        call_([](void* to, const contact_geometry& c) { (*static_cast<Sink*>(to))(c); }) {}
  void operator()(const contact_geometry& c) const { call_(sink_, c); }

 private:
  void* sink_;
  void (*call_)(void*, const contact_geometry&);
};

}  // namespace talus::detail
