# The steel sphere reaches the floor of a shallow bed and rebounds, slower than it came.
set(impact ARGS --quiet)
set(rebounds "bodies EQUAL 1001" "lowest LESS -0.0255" "lowest GREATER -0.0275" "speed LESS 2.5"
             "bed_height GREATER 0.0105" "bed_height LESS 0.0135" "dt_above_critical EQUAL 0")
add_example_test(alone ${impact} CHECK ${rebounds})
add_example_test(threads ${impact} --ranks 2 CHECK ${rebounds})
