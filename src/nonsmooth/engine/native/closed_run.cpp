// Runs of closed forms alone: the source of all runs once more, in a namespace of its own, in which
// compilers leave out series and derivatives. Most long runs are such, and take a twentieth less.
#define NONSMOOTH_CLOSED_FORMS
#define nonsmooth nonsmooth_closed
#define nonsmooth_run_lanes nonsmooth_run_closed_lanes
#define nonsmooth_run_sweep nonsmooth_run_closed_sweep
#include "run.cpp"
