/* The C interface, compiled as C99. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "robot_dynamics.h"

static int failures = 0;

#define CHECK(condition)                                                             \
    do {                                                                             \
        if (!(condition)) {                                                          \
            ++failures;                                                              \
            fprintf(stderr, "%s:%d: %s fails: %s\n", __FILE__, __LINE__, #condition, \
                    rd_error_message());                                             \
        }                                                                            \
    } while (0)

int main(void) {
    CHECK(rd_version() == RD_VERSION);
    CHECK(rd_abi_version() == RD_ABI_VERSION);

    rd_model model = {0};
    rd_workspace workspace = {0};
    CHECK(rd_load(ROBOTS "panda.urdf", NULL, &model) == RD_STATUS_OK);
    CHECK(rd_workspace_new(model, &workspace) == RD_STATUS_OK);
    CHECK(rd_model_nq(model) == 7 && rd_model_nv(model) == 7);
    CHECK(strcmp(rd_model_name(model), "panda") == 0);

    double q[7], v[7] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}, zero[7] = {0}, tau[7], g[7];
    CHECK(rd_random_configuration(model, 1, q, 7) == RD_STATUS_OK);
    CHECK(rd_inverse_dynamics(workspace, q, 7, zero, 7, zero, 7, tau, 7) == RD_STATUS_OK);
    CHECK(rd_gravity(workspace, q, 7, g, 7) == RD_STATUS_OK);
    for (int i = 0; i < 7; ++i) {
        CHECK(fabs(tau[i] - g[i]) < 1e-12);
    }

    /* The same quantity by the table. */
    rd_inputs inputs = {0};
    rd_results results = {0};
    uint32_t quantity = 0;
    inputs.q = q, inputs.q_len = 7, inputs.v = v, inputs.v_len = 7;
    results.first = tau, results.first_len = 7;
    CHECK(rd_quantity_named("bias", &quantity) == RD_STATUS_OK && quantity == RD_QUANTITY_BIAS);
    CHECK(rd_compute(workspace, quantity, &inputs, &results) == RD_STATUS_OK);
    CHECK(rd_bias(workspace, q, 7, v, 7, g, 7) == RD_STATUS_OK);
    CHECK(memcmp(tau, g, sizeof g) == 0);

    /* Errors. */
    CHECK(rd_gravity(workspace, q, 6, g, 7) == RD_STATUS_INVALID_INPUT);
    CHECK(rd_gravity(workspace, NULL, 7, g, 7) == RD_STATUS_INVALID_INPUT);
    CHECK(rd_gravity(workspace, q, 7, q, 7) == RD_STATUS_INVALID_INPUT);
    CHECK(strstr(rd_error_message(), "overlaps") != NULL);
    rd_workspace null = {0}, foreign = {model.id};
    CHECK(rd_gravity(null, q, 7, g, 7) == RD_STATUS_INVALID_HANDLE);
    CHECK(rd_gravity(foreign, q, 7, g, 7) == RD_STATUS_INVALID_HANDLE);
    CHECK(rd_load("nowhere.urdf", NULL, &model) == RD_STATUS_FILE);

    /* A workspace outlives its model's handle. */
    CHECK(rd_model_free(model) == RD_STATUS_OK);
    CHECK(rd_model_free(model) == RD_STATUS_INVALID_HANDLE);
    CHECK(rd_gravity(workspace, q, 7, g, 7) == RD_STATUS_OK);
    CHECK(rd_workspace_free(workspace) == RD_STATUS_OK);
    CHECK(rd_gravity(workspace, q, 7, g, 7) == RD_STATUS_INVALID_HANDLE);
    CHECK(rd_workspace_free(null) == RD_STATUS_OK);

    if (failures == 0) {
        puts("all checks of the C interface passed");
    }
    return failures != 0;
}
