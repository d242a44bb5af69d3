// A feature of one's own: heat that flows through contacts. It uses what talus offers to anybody,
// and nothing inside it.
#pragma once
#include <cmath>
#include <cstdint>
#include <talus/feature.hpp>
#include <type_traits>
#include <vector>

/// A body has one temperature.
struct temperature {
  using value_type = double;
  static constexpr const char *name = "temperature", *unit = "K";
  static constexpr double initial = 293.15;
  static constexpr talus::travels travel = talus::travels::with_every_refresh;
};
/// 1 for a body that keeps its temperature. Walls that do not are adiabatic.
struct reservoir {
  using value_type = std::uint8_t;
  static constexpr const char* name = "reservoir";
  static constexpr talus::travels travel = talus::travels::when_changed;
  static constexpr bool in_output = false;
};

struct heat {
  using talus_part_of = talus::roles::features;
  static constexpr const char* name = "heat";
  using columns = talus::type_list<temperature, reservoir>;

  struct state {
    double capacity = 1;          // of a unit of mass, L^2/(T^2 K)
    double conductivity = 1;      // M L/(T^3 K), where contacts are soft
    double hard_conductance = 1;  // of a hard contact, M L^2/(T^3 K)
    double inflow = 0;            // energy that reservoirs gave to the bodies of this rank

    void each_number(auto& visit) { visit.sum(inflow); }  // what a checkpoint holds
  };

  struct hooks {
    static void after_solve(auto& stage) {
      auto& s = stage.state();
      std::vector<double> gained(stage.bodies(), 0.0);
      stage.for_each_contact([&](const talus::stage_contact& c) {
        const end a = end_of(stage, c.body_a), b = end_of(stage, c.body_b);
        if (a.adiabatic || b.adiabatic) return;
        // Smooth spheres: H = 2 k r, r the radius of the area of contact (Batchelor, O'Brien 1977).
        double conductance = s.hard_conductance;
        if constexpr (std::remove_cvref_t<decltype(stage)>::scenario_type::contact_law::soft)
          conductance = 2 * s.conductivity * std::sqrt(-c.gap / (a.curvature + b.curvature));
        const double flow = stage.dt() * conductance * (b.temperature - a.temperature);
        gained[c.body_a] += flow;
        gained[c.body_b] -= flow;
        if (!c.counts_here) return;
        if (a.reservoir) s.inflow -= flow;
        if (b.reservoir) s.inflow += flow;
      });
      stage.for_each_local([&](const auto& body) {
        if (body.template get<reservoir>()) return;
        const double of_body = body.mass() * s.capacity;
        body.template set<temperature>(body.template get<temperature>() +
                                       gained[body.number()] / of_body);
      });
    }

   private:
    struct end {
      double temperature = 0, curvature = 0;
      bool reservoir = false, adiabatic = false;
    };
    static end end_of(const auto& stage, std::size_t number) {
      end e;
      stage.with_body(number, [&](const auto& body) {
        e.temperature = body.template get<::temperature>();
        e.reservoir = body.template get<::reservoir>();
        e.adiabatic = body.is_global() && !e.reservoir;
        if constexpr (requires { body.shape().radius; }) e.curvature = 1 / body.shape().radius;
      });
      return e;
    }
  };
};

/// Collective: the heat in all bodies that are not global.
double thermal_energy(auto& world) {
  double sum = 0;
  world.for_each_local([&](const auto& body) {
    sum += body.mass() * world.template feature<heat>().capacity * body.template get<temperature>();
  });
  world.link().reduce(talus::reduction::sum, std::span(&sum, 1));
  return sum;
}
/// Collective: what reservoirs gave since the run began.
double heat_given(auto& world) {
  double sum = world.template feature<heat>().inflow;
  world.link().reduce(talus::reduction::sum, std::span(&sum, 1));
  return sum;
}
