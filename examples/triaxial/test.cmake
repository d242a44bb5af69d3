# Dense grains have a peak and dilate; loose ones do not, and both tend to some 20 to 25 degrees, as spheres with this
# friction do elsewhere (Thornton 2000; Suiker, Fleck 2004). The lateral stress is the one that the walls hold, within 0.5 %
# in the mean over the last 3 % of strain and within 4 % at any time.
set(held "lateral_stress GREATER 0.995" "lateral_stress LESS 1.005" "lateral_error LESS 0.04" "unbalanced_force LESS 0.03"
         "friction_angle GREATER 18" "friction_angle LESS 26" "dt_above_critical EQUAL 0")
add_example_test(dense ARGS --quiet CHECK ${held} "peak_friction_angle GREATER 26.5" "peak_friction_angle LESS 32"
                                          "volumetric_strain LESS -0.02" "solid_fraction_at_start GREATER 0.57")
add_example_test(loose ARGS --quiet --start-friction 0.5 CHECK ${held} "peak_friction_angle LESS 26"
                                                               "volumetric_strain GREATER 0"
                                                               "solid_fraction_at_start LESS 0.56")

# The same bits and results on any ranks, and after a restart while the grains are sheared.
add_same_bits_test(same_bits RESTART STEPS 3000 ARGS --grains 216
                   RESULTS peak_friction_angle friction_angle lateral_stress unbalanced_force coordination
                   RUNS "--ranks 1" "--ranks 2" "mpi 2")
