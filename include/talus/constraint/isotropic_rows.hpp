#pragma once
// The rows of contacts of isotropic bodies, one contact or as many as a pack has lanes, and their
// local solution.
#include <type_traits>

#include "talus/contact/law.hpp"
#include "talus/core/math.hpp"
#include "talus/core/pack.hpp"
#include "talus/core/pack_rows.hpp"
#include "talus/core/pack_vector.hpp"

namespace talus::detail {

// All functions that take packs are inlined.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

/// Velocities of both bodies of a contact (each followed by the inverse mass), or angular
/// velocities (by the inverse inertia). `AtA` and `AtB` are functions that return where they are
/// stored, for each lane.
template <class Pack, bool Paired, class AtA, class AtB>
struct ends_of_contact {
  AtA at_a;
  AtB at_b;
  pack_rows<Pack> a, b;

  ends_of_contact(AtA of_a, AtB of_b) : at_a(of_a), at_b(of_b) {}
  [[gnu::always_inline]] void read() {
    a = gather<Pack>(at_a);
    if constexpr (Paired) b = gather<Pack>(at_b);
  }
  [[gnu::always_inline]] void write() const {
    scatter(a, at_a);
    if constexpr (Paired) scatter(b, at_b);
  }
  /// The velocity of a relative to b.
  [[nodiscard]] [[gnu::always_inline]] vectors_of<Pack> relative() const {
    vectors_of<Pack> u = vectors_in(a);
    if constexpr (Paired) u -= vectors_in(b);
    return u;
  }
  /// The change by an impulse on a, and its opposite on b.
  [[gnu::always_inline]] void push(const vectors_of<Pack>& impulse) {
    a += a.w * impulse;
    if constexpr (Paired) b -= b.w * impulse;
  }
  /// Changes the velocities by an impulse of this magnitude along `direction` on a, and by its
  /// opposite on b. It multiplies impulse and inverse mass first.
  [[gnu::always_inline]] void push(const Pack& impulse, const vectors_of<Pack>& direction) {
    a += (impulse * a.w) * direction;
    if constexpr (Paired) b -= (impulse * b.w) * direction;
  }
  /// For angular velocities: at() sums them, weighted by the lengths of the arms; turn() changes
  /// them by the moment of an impulse at arms of length 1, times these lengths.
  [[nodiscard]] [[gnu::always_inline]] vectors_of<Pack> at(const Pack& arm_a,
                                                           const Pack& arm_b) const {
    vectors_of<Pack> w = arm_a * vectors_in(a);
    if constexpr (Paired) w += arm_b * vectors_in(b);
    return w;
  }
  [[gnu::always_inline]] void turn(const Pack& arm_a, const Pack& arm_b,
                                   const vectors_of<Pack>& moment) {
    a -= (arm_a * a.w) * moment;
    if constexpr (Paired) b -= (arm_b * b.w) * moment;
  }
};

/// An impulse of a contact, or a change of it.
template <class Pack, class Cone>
struct isotropic_impulse {
  vectors_of<Pack> t = {Pack{}, Pack{}, Pack{}};
  Pack n{};

  friend isotropic_impulse operator+(const isotropic_impulse& x, const isotropic_impulse& y) {
    return {x.t + y.t, x.n + y.n};
  }
  friend isotropic_impulse operator-(const isotropic_impulse& x, const isotropic_impulse& y) {
    return {x.t - y.t, x.n - y.n};
  }
  friend isotropic_impulse operator*(Pack f, const isotropic_impulse& x) {
    return {f * x.t, f * x.n};
  }
  [[nodiscard]] [[gnu::always_inline]] Pack dot(const isotropic_impulse& x) const {
    return n * x.n + detail::dot(t, x.t);
  }
  [[nodiscard]] [[gnu::always_inline]] vectors_of<Pack> along(
      const vectors_of<Pack>& normal) const {
    return n * normal + t;
  }
};
template <class Pack>
struct isotropic_impulse<Pack, frictionless> {
  Pack n{};

  friend isotropic_impulse operator+(const isotropic_impulse& x, const isotropic_impulse& y) {
    return {x.n + y.n};
  }
  friend isotropic_impulse operator-(const isotropic_impulse& x, const isotropic_impulse& y) {
    return {x.n - y.n};
  }
  friend isotropic_impulse operator*(Pack f, const isotropic_impulse& x) { return {f * x.n}; }
  [[nodiscard]] [[gnu::always_inline]] Pack dot(const isotropic_impulse& x) const {
    return n * x.n;
  }
  [[nodiscard]] [[gnu::always_inline]] vectors_of<Pack> along(
      const vectors_of<Pack>& normal) const {
    return n * normal;
  }
};

/// The tangential rows of contacts, if there is friction; else they have no data, and functions
/// without effect.
template <class Pack, class Cone>
struct tangential_rows {
  vectors_of<Pack> rt = {Pack{}, Pack{}, Pack{}};  ///< tangential impulse
  Pack inverse_wt{};
  Pack arm_a{};  ///< distance of the contact point from the centre of a, b
  Pack arm_b{};
  Pack friction{};  ///< coefficient mu

 protected:
  using vectors = vectors_of<Pack>;
  using impulse_type = isotropic_impulse<Pack, Cone>;

  [[nodiscard]] Pack coefficient() const { return friction; }
  [[nodiscard]] Pack distance_a() const { return arm_a; }
  [[nodiscard]] Pack distance_b() const { return arm_b; }

  [[nodiscard]] [[gnu::always_inline]] impulse_type with_normal(const Pack& n) const {
    return {rt, n};
  }
  [[gnu::always_inline]] void store(const impulse_type& r) { rt = r.t; }
  /// An impulse that is still to be loaded into lane l takes the place of the tangential one.
  void keep(std::size_t l, const auto& impulse, const auto&, Pack&) { put_lane(rt, l, impulse); }
  [[gnu::always_inline]] void keep(const vectors& impulse, const vectors&, Pack&) { rt = impulse; }
  [[nodiscard]] [[gnu::always_inline]] impulse_type kept(const Pack&, const vectors& normal) const {
    return in_frame(rt, normal);
  }
  [[gnu::always_inline]] void set_arms(const Pack& of_a, const Pack& of_b) {
    arm_a = of_a, arm_b = of_b;
  }
  /// Calls f(data of x, the same of y).
  static void each_part(auto& x, auto& y, auto&& f) {
    f(x.rt, y.rt), f(x.inverse_wt, y.inverse_wt), f(x.friction, y.friction);
    f(x.arm_a, y.arm_a), f(x.arm_b, y.arm_b);
  }
  /// The impulse in the world, in the frame of the contact.
  [[nodiscard]] [[gnu::always_inline]] static impulse_type in_frame(const vectors& impulse,
                                                                    const vectors& normal) {
    const Pack n = detail::dot(normal, impulse);
    return {impulse - n * normal, n};
  }
  [[gnu::always_inline]] void project(impulse_type& r) const { Cone::project(r.n, r.t, friction); }

  /// `wn` is the Delassus diagonal along the normal, `turning` the part by the rotation of the
  /// bodies across it.
  template <class Turning>
  [[gnu::always_inline]] void set_mobility(const Pack& wn, Turning&& turning) {
    inverse_wt = 1 / turning(wn);
  }
  /// The impulse that also stops the slip. `u` is the relative velocity of the centres.
  template <class Spins>
  [[nodiscard]] [[gnu::always_inline]] impulse_type stopping(const Pack& n, const vectors& u,
                                                             const Pack& un, const vectors& normal,
                                                             Spins& spins) const {
    spins.read();
    return {rt - inverse_wt * (u - un * normal + crossed(normal, spins.at(arm_a, arm_b))), n};
  }
  template <class Spins>
  [[gnu::always_inline]] static void read(Spins& spins) {
    spins.read();
  }
  /// Changes the angular velocities of bodies with these arms, which have been read.
  template <class Spins>
  [[gnu::always_inline]] static void turn(const impulse_type& d, const vectors& normal,
                                          const Pack& of_a, const Pack& of_b, Spins& spins) {
    spins.turn(of_a, of_b, crossed(normal, d.t));
    spins.write();
  }
  /// The relative velocity that the contact acts against.
  template <class Spin>
  [[nodiscard]] static auto resisted(const auto& u, const auto& normal, Spin&& spin) {
    return u + crossed(normal, spin());
  }
};
template <class Pack>
struct tangential_rows<Pack, frictionless> {
 protected:
  using vectors = vectors_of<Pack>;
  using impulse_type = isotropic_impulse<Pack, frictionless>;

  [[nodiscard]] Pack coefficient() const { return Pack{}; }
  [[nodiscard]] Pack distance_a() const { return Pack{}; }
  [[nodiscard]] Pack distance_b() const { return Pack{}; }

  [[nodiscard]] [[gnu::always_inline]] impulse_type with_normal(const Pack& n) const { return {n}; }
  [[gnu::always_inline]] void store(const impulse_type&) {}
  static void keep(std::size_t l, const auto& impulse, const auto& normal, Pack& rn) {
    rn[l] = detail::dot(normal, impulse);
  }
  [[gnu::always_inline]] static void keep(const vectors& impulse, const vectors& normal, Pack& rn) {
    rn = detail::dot(normal, impulse);
  }
  [[nodiscard]] [[gnu::always_inline]] impulse_type kept(const Pack& rn, const vectors&) const {
    return {rn};
  }
  [[gnu::always_inline]] static void set_arms(const Pack&, const Pack&) {}
  static void each_part(auto&, auto&, auto&&) {}
  [[nodiscard]] [[gnu::always_inline]] static impulse_type in_frame(const vectors& impulse,
                                                                    const vectors& normal) {
    return {detail::dot(normal, impulse)};
  }
  [[gnu::always_inline]] void project(impulse_type& r) const { frictionless::project(r.n); }
  [[gnu::always_inline]] void set_mobility(const Pack&, auto&&) {}
  [[nodiscard]] [[gnu::always_inline]] impulse_type stopping(const Pack& n, const vectors&,
                                                             const Pack&, const vectors&,
                                                             auto&) const {
    return {n};
  }
  [[gnu::always_inline]] static void read(auto&) {}
  [[gnu::always_inline]] static void turn(const impulse_type&, const vectors&, const Pack&,
                                          const Pack&, auto&) {}
  [[nodiscard]] static auto resisted(const auto& u, const auto& normal, auto&&) {
    return detail::dot(normal, u) * normal;
  }
};

/// The Delassus block of such a contact is diagonal: w_n = 1/m_a + 1/m_b along the normal and w_t =
/// w_n + arm_a^2/I_a + arm_b^2/I_b across it. So the exact local solution needs no tangent basis
/// and no tensor: the impulse r - w^-1 (u - target), projected into the cone of the law. Velocities
/// are those of a relative to b, impulses act on a. Without friction nothing tangential is stored
/// or computed.
template <class Pack, class Cone, bool Paired>
struct isotropic_rows : tangential_rows<Pack, Cone> {
  using vectors = vectors_of<Pack>;
  using change = isotropic_impulse<Pack, Cone>;  ///< of the impulse

  vectors normal = {Pack{}, Pack{}, Pack{} + 1};  ///< from b to a
  Pack inverse_wn{};
  Pack target_velocity{};  ///< least separating velocity after the step
  Pack rn{};               ///< normal impulse

  [[nodiscard]] [[gnu::always_inline]] change impulse_in_frame() const {
    return this->with_normal(rn);
  }
  /// Replaces the impulse, which may leave the cone for a while; the change is still to be applied.
  [[gnu::always_inline]] void set(const change& r) {
    rn = r.n;
    this->store(r);
  }

  // Contacts of one lane each are put into lanes.
  using one_lane = isotropic_rows<lane_of<Pack>, Cone, Paired>;
  void put(std::size_t l, const one_lane& c) {
    each_part(*this, c, [l](auto& mine, const auto& of_c) { put_lane(mine, l, of_c); });
  }
  void get(std::size_t l, one_lane& c) const {
    each_part(*this, c, [l](const auto& mine, auto& of_c) { of_c = lane(mine, l); });
  }
  /// The impulse of lane l, in the world.
  [[nodiscard]] [[gnu::always_inline]] vector3<lane_of<Pack>> impulse_of(std::size_t l) const {
    typename one_lane::change r;
    r.n = lane(rn, l);
    if constexpr (requires { r.t; }) r.t = lane(this->rt, l);
    return r.along(lane(normal, l));
  }
  /// Keeps an impulse of the last step for lane l; then load_kept_impulses() loads those of all.
  void keep_impulse(std::size_t l, const vector3<lane_of<Pack>>& impulse) {
    tangential_rows<Pack, Cone>::keep(l, impulse, lane(normal, l), rn);
  }
  /// Keeps the impulses of all lanes, which get new normals and arms.
  [[gnu::always_inline]] void renew(const vectors& next, const Pack& arm_a, const Pack& arm_b) {
    const vectors impulse = impulse_in_frame().along(normal);
    normal = next;
    this->set_arms(arm_a, arm_b);
    tangential_rows<Pack, Cone>::keep(impulse, normal, rn);
  }
  void load_kept_impulses() {
    change r = this->kept(rn, normal);
    this->project(r);
    set(r);
  }

 protected:
  static void each_part(auto& x, auto& y, auto&& f) {
    tangential_rows<Pack, Cone>::each_part(x, y, f);
    f(x.normal, y.normal), f(x.inverse_wn, y.inverse_wn), f(x.rn, y.rn);
    f(x.target_velocity, y.target_velocity);
  }
  /// Warm start from an impulse of the last step, projected into the present cone.
  [[gnu::always_inline]] void load_impulse_in(const vectors& impulse) {
    change r = this->in_frame(impulse, normal);
    this->project(r);
    set(r);
  }
  /// Effective masses, from inverse masses and moments of inertia. The masses of a and b are
  /// divided into `split_a` and `split_b` parts if several contacts are solved simultaneously (else
  /// 1).
  [[gnu::always_inline]] void set_effective_mass(const Pack& split_a, const Pack& mass_a,
                                                 const Pack& inertia_a, const Pack& split_b,
                                                 const Pack& mass_b, const Pack& inertia_b) {
    Pack wn = split_a * mass_a;
    if constexpr (Paired) wn += split_b * mass_b;
    inverse_wn = 1 / wn;
    this->set_mobility(wn, [&](const Pack& across) {
      Pack wt = across;
      const Pack arm_a = this->distance_a(), arm_b = this->distance_b();
      wt += split_a * arm_a * arm_a * inertia_a;
      if constexpr (Paired) wt += split_b * arm_b * arm_b * inertia_b;
      return wt;
    });
  }
  /// Solves the contact with all others held; the change is still to be applied. `u` is the
  /// relative velocity of the centres, without the bias.
  template <class Spins>
  [[gnu::always_inline]] change solve(const vectors& u, Spins& spins) {
    const Pack un = detail::dot(normal, u);
    change r = this->stopping(rn - (un - target_velocity) * inverse_wn, u, un, normal, spins);
    this->project(r);
    const change d = r - impulse_in_frame();
    set(r);
    return d;
  }
  /// The change of the correction's impulse if surfaces separate at `rate`. Surfaces under load
  /// neither separate nor approach except by the position correction.
  [[nodiscard]] [[gnu::always_inline]] Pack correct_at(const Pack& rate, const Pack& required,
                                                       Pack& impulse) const {
    const Pack zero = every_lane<Pack>(0), free = impulse - (rate - required) * inverse_wn;
    const auto held = (target_velocity == zero) & (rn > zero);
    const Pack next = (held | (free > zero)) ? free : zero;
    const Pack d = next - impulse;
    impulse = next;
    return d;
  }
};

#pragma GCC diagnostic pop

}  // namespace talus::detail
