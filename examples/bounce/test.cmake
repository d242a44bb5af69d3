# long: one ball. From a height of 1 with restitution 0.8 it comes back to 0.64, at any time step.
add_example_test(alone LONG ARGS --quiet CHECK "bodies EQUAL 1" "height GREATER 0.63" "height LESS 0.645")
