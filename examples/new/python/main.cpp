// The scene as a program: ./build/@NAME@ --help
#include "scene.hpp"

int main(int argc, char** argv) { return run<scene, scene_options>(argc, argv, set_up); }
