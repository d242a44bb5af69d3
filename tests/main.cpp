// The main function that all tests share. Written out, because doctest's own macro for it has no
// effect behind a precompiled header; nor would it in an MPI test with a main of its own.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

int main(int argc, char** argv) { return doctest::Context(argc, argv).run(); }
