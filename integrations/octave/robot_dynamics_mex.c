/* Robot dynamics for Octave and MATLAB: a MEX function over the C interface.
 *
 *   handle = robot_dynamics_mex('load', path)           a robot, on a fixed base
 *   handle = robot_dynamics_mex('load', path, true)     a robot whose base floats
 *   n      = robot_dynamics_mex('nq', handle)           the length of q
 *   n      = robot_dynamics_mex('nv', handle)           the length of v, a and tau
 *   names  = robot_dynamics_mex('names', handle)        the names of the coordinates of v, a cell array
 *   q      = robot_dynamics_mex('neutral', handle)      the neutral configuration
 *   g      = robot_dynamics_mex('gravity', handle, q)
 *   M      = robot_dynamics_mex('mass_matrix', handle, q)
 *   tau    = robot_dynamics_mex('inverse_dynamics', handle, q, v, a)
 *   a      = robot_dynamics_mex('forward_dynamics', handle, q, v, tau)
 *            robot_dynamics_mex('free', handle)
 *
 * Results are columns. Units are SI. The identifier of an error has the status, such as
 * robot_dynamics:invalid_handle.
 */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "mex.h"
#include "robot_dynamics.h"

/* A handle is two numbers of 64 bits: those of the model and of its workspace. */
typedef struct {
    rd_model model;
    rd_workspace workspace;
} robot;

static void check(rd_status status) {
    char identifier[80];
    if (status == RD_STATUS_OK) {
        return;
    }
    snprintf(identifier, sizeof identifier, "robot_dynamics:%s", rd_status_name(status));
    for (char *c = identifier; *c; ++c) {
        if (*c == ' ') {
            *c = '_';
        }
    }
    mexErrMsgIdAndTxt(identifier, "%s", rd_error_message());
}

static void refuse(const char *text) {
    mexErrMsgIdAndTxt("robot_dynamics:invalid_input", "%s", text);
}

static robot robot_of(const mxArray *array) {
    robot it;
    const uint64_t *numbers;
    if (!mxIsUint64(array) || mxGetNumberOfElements(array) != 2) {
        refuse("the second argument must be a handle, which 'load' returns");
    }
    numbers = (const uint64_t *)mxGetData(array);
    it.model.id = numbers[0];
    it.workspace.id = numbers[1];
    return it;
}

static const double *numbers_of(const mxArray *array) {
    if (!mxIsDouble(array) || mxIsComplex(array) || mxIsSparse(array)) {
        refuse("arguments must be full arrays of real double numbers");
    }
    return mxGetPr(array);
}

static mxArray *load(int count, const mxArray *arguments[]) {
    rd_load_options options;
    robot it;
    mxArray *handle;
    uint64_t *numbers;
    rd_status status;
    char *path;
    if (count < 1 || count > 2 || !mxIsChar(arguments[0])) {
        refuse("'load' takes the path of a file and, optionally, whether the base floats");
    }
    memset(&options, 0, sizeof options);
    options.floating_base = count == 2 && mxGetScalar(arguments[1]) != 0.0;
    path = mxArrayToString(arguments[0]);
    status = rd_load(path, &options, &it.model);
    mxFree(path);
    check(status);
    status = rd_workspace_new(it.model, &it.workspace);
    if (status != RD_STATUS_OK) {
        rd_model_free(it.model);
        check(status);
    }
    handle = mxCreateNumericMatrix(1, 2, mxUINT64_CLASS, mxREAL);
    numbers = (uint64_t *)mxGetData(handle);
    numbers[0] = it.model.id;
    numbers[1] = it.workspace.id;
    return handle;
}

static mxArray *names(robot it) {
    size_t nv = rd_model_nv(it.model);
    mxArray *cells = mxCreateCellMatrix((mwSize)nv, 1);
    for (size_t k = 0; k < nv; ++k) {
        mxSetCell(cells, (mwIndex)k, mxCreateString(rd_model_coordinate_name(it.model, k)));
    }
    return cells;
}

static mxArray *column(size_t length) {
    return mxCreateDoubleMatrix((mwSize)length, 1, mxREAL);
}

typedef rd_status (*of_state)(rd_workspace, const double *, size_t, const double *, size_t, const double *,
                              size_t, double *, size_t);

/* A quantity of q, v and a third vector. */
static mxArray *from_state(of_state compute, robot it, const mxArray *arguments[]) {
    mxArray *out = column(rd_model_nv(it.model));
    check(compute(it.workspace, numbers_of(arguments[0]), mxGetNumberOfElements(arguments[0]),
                  numbers_of(arguments[1]), mxGetNumberOfElements(arguments[1]), numbers_of(arguments[2]),
                  mxGetNumberOfElements(arguments[2]), mxGetPr(out), mxGetNumberOfElements(out)));
    return out;
}

/* The result of a function of a robot, or null if the function is unknown. */
static mxArray *call(const char *function, robot it, int count, const mxArray *arguments[]) {
    size_t nv = rd_model_nv(it.model);
    mxArray *out;
    if (count == 0 && strcmp(function, "nq") == 0) {
        return mxCreateDoubleScalar((double)rd_model_nq(it.model));
    }
    if (count == 0 && strcmp(function, "nv") == 0) {
        return mxCreateDoubleScalar((double)nv);
    }
    if (count == 0 && strcmp(function, "names") == 0) {
        return names(it);
    }
    if (count == 0 && strcmp(function, "neutral") == 0) {
        out = column(rd_model_nq(it.model));
        check(rd_neutral(it.model, mxGetPr(out), mxGetNumberOfElements(out)));
        return out;
    }
    if (count == 1 && strcmp(function, "gravity") == 0) {
        out = column(nv);
        check(rd_gravity(it.workspace, numbers_of(arguments[0]), mxGetNumberOfElements(arguments[0]), mxGetPr(out),
                         nv));
        return out;
    }
    if (count == 1 && strcmp(function, "mass_matrix") == 0) {
        /* M is symmetric, so that its rows are also the columns that Octave stores. */
        out = mxCreateDoubleMatrix((mwSize)nv, (mwSize)nv, mxREAL);
        check(rd_mass_matrix(it.workspace, numbers_of(arguments[0]), mxGetNumberOfElements(arguments[0]),
                             mxGetPr(out), nv * nv));
        return out;
    }
    if (count == 3 && strcmp(function, "inverse_dynamics") == 0) {
        return from_state(rd_inverse_dynamics, it, arguments);
    }
    if (count == 3 && strcmp(function, "forward_dynamics") == 0) {
        return from_state(rd_forward_dynamics, it, arguments);
    }
    return NULL;
}

void mexFunction(int result_count, mxArray *results[], int count, const mxArray *arguments[]) {
    char function[32];
    (void)result_count;
    if (count < 2 || !mxIsChar(arguments[0]) || mxGetString(arguments[0], function, sizeof function) != 0) {
        refuse("the first arguments must be the name of a function and a handle, or 'load' and a path");
    }
    if (!mexIsLocked()) {
        if (rd_abi_version() != RD_ABI_VERSION) {
            refuse("robot_dynamics_mex was compiled for another version of the library");
        }
        /* Handles remain valid after "clear all". */
        mexLock();
    }
    if (strcmp(function, "load") == 0) {
        results[0] = load(count - 1, arguments + 1);
    } else if (strcmp(function, "free") == 0) {
        robot it = robot_of(arguments[1]);
        check(rd_workspace_free(it.workspace));
        check(rd_model_free(it.model));
    } else {
        results[0] = call(function, robot_of(arguments[1]), count - 2, arguments + 2);
        if (results[0] == NULL) {
            refuse("no function of robot_dynamics_mex has this name and this number of arguments");
        }
    }
}
