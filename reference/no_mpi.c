// A SUNDIALS that was built with MPI wants these from whoever links its static libraries, and calls none of them for the
// null communicator, the only one that odeval gives it. MPI itself stays out: as soon as it is loaded, before main,
// libraries below it take over SIGHUP, SIGSEGV and others, so that a hangup no longer ends the program.
#include <mpi.h>
#include <stdlib.h>

int MPI_Comm_dup(MPI_Comm of, MPI_Comm* made) {
  (void)of, (void)made;
  abort();
}

int MPI_Comm_free(MPI_Comm* of) {
  (void)of;
  abort();
}

int MPI_Comm_rank(MPI_Comm in, int* rank) {
  (void)in, (void)rank;
  abort();
}

#ifdef OPEN_MPI // where the null communicator is the address of a variable
struct ompi_predefined_communicator_t {
  int never_read;
} ompi_mpi_comm_null;
#endif
