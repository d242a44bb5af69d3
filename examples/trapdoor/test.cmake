# Hinge and weld bear the weight of flap and grains; the weld breaks under the ball and the grains fall
# through: on one rank and on four.
set(opens "weight_borne GREATER 0.995" "weight_borne LESS 1.005" "held EQUAL 1" "broken EQUAL 1"
          "grains_through GREATER 360" "joint_gap LESS 1e-3")
add_example_test(alone ARGS --quiet --ranks 1 CHECK ${opens})
add_example_test(threads ARGS --quiet --reproducible --ranks 4 CHECK ${opens})
# A strong weld holds.
add_example_test(closed ARGS --quiet --ranks 1 --strength 1000 --grains 100 CHECK "broken EQUAL 0" "grains_through EQUAL 0")
