/* The torques that hold a robot still, in C. */
#include <stdio.h>
#include <stdlib.h>

#include "robot_dynamics.h"

/* Ends the program with the text of the last error. */
static void check(rd_status status) {
    if (status != RD_STATUS_OK) {
        fprintf(stderr, "%s: %s\n", rd_status_name(status), rd_error_message());
        exit(EXIT_FAILURE);
    }
}

int main(int argc, char **argv) {
    rd_model model;
    rd_workspace workspace;
    check(rd_load(argc > 1 ? argv[1] : "robots/panda.urdf", NULL, &model));
    check(rd_workspace_new(model, &workspace));

    size_t nq = rd_model_nq(model), nv = rd_model_nv(model);
    double *q = calloc(nq, sizeof *q), *g = calloc(nv, sizeof *g);
    check(rd_neutral(model, q, nq));
    check(rd_gravity(workspace, q, nq, g, nv));
    for (size_t i = 0; i < nv; ++i) {
        printf("%-24s %10.4f\n", rd_model_coordinate_name(model, i), g[i]);
    }

    free(q);
    free(g);
    check(rd_workspace_free(workspace));
    check(rd_model_free(model));
    return EXIT_SUCCESS;
}
