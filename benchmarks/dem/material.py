"""What all engines are given; the same numbers as in benchmarks/scenes/bed_scene.hpp."""
RADIUS = 0.005
YOUNG, POISSON, DENSITY = 1e7, 0.3, 2500
RESTITUTION, FRICTION, GRAVITY = 0.5, 0.5, 9.81
SKIN = 0.2 * RADIUS  # of a pair, as in talus
