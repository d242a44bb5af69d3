# long
# All fall, and without friction between them the wave has the speed of the theory within 3 %; with
# friction it is slower, and some stay leaning.
set(falls "fallen EQUAL 40" "collectives_per_step EQUAL 0")
set(as_theory "speed_to_theory GREATER 0.97" "speed_to_theory LESS 1.03")
add_example_test(alone ARGS --quiet CHECK ${falls} ${as_theory})
add_example_test(near LONG ARGS --quiet --gap 0.2 --steps 3000 CHECK ${falls} ${as_theory})
add_example_test(threads ARGS --quiet --ranks 2 CHECK ${falls} ${as_theory})
add_example_test(friction ARGS --quiet --friction 0.2 --steps 3400
                 CHECK "fallen GREATER 30" "speed_to_theory GREATER 0.6" "speed_to_theory LESS 0.97")

# The same bits on any ranks.
add_same_bits_test(same_bits RESTART STEPS 200 ARGS --reproducible --dominoes 20 --gap 0.1
                   RUNS "--ranks 1" "--ranks 2" "mpi 2")
