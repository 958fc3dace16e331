/* The C interface of robot-dynamics. This file is generated from crates/c; do not edit it.
 *
 * - Objects are handles. Null handles, handles of other objects and handles of freed objects are errors.
 * - Functions return a status. `rd_error_message` has the text of the last error of the calling thread.
 * - Arrays are a pointer and a length; a pointer with the length 0 may be null. Matrices are row-major.
 *   Outputs must not overlap other arrays of the call, except where a function works in place.
 * - Each pointer must point to as many numbers as its length says; texts are UTF-8 and end with a zero byte.
 * - Units are SI: m, rad, kg, s, N, N m. Quaternions are x y z w. q has nq numbers; v, a and tau have nv.
 * - A model and its constraints serve any number of threads at once. Every other object serves one call at a
 *   time, on any thread; a second call at the same time returns RD_STATUS_IN_USE. No function waits for another,
 *   except those that make or free objects.
 * - Functions for control loops do not allocate; others say that they do. Failed calls may allocate, and so may
 *   the first two calls of a function, which make machine code.
 */

#ifndef ROBOT_DYNAMICS_H
#define ROBOT_DYNAMICS_H

#include <stddef.h>
#include <stdint.h>

/**
 * The version of the package, major · 10000 + minor · 100 + patch.
 */
#define RD_VERSION 100

/**
 * The version of this interface. Programs of another version are not compatible with the library.
 */
#define RD_ABI_VERSION 0

/**
 * The parameters of joints that a record identifies beside the inertial ones: bits of `joint_terms`.
 */
#define RD_TERM_DAMPING 1

/**
 * Dry friction.
 */
#define RD_TERM_FRICTION 2

/**
 * The reflected inertia of motors.
 */
#define RD_TERM_ARMATURE 4

/**
 * A constant torque.
 */
#define RD_TERM_OFFSET 8

/**
 * The result of a call.
 */
typedef enum {
  /**
   * The call succeeded.
   */
  RD_STATUS_OK = 0,
  /**
   * A file cannot be read, or its text is refused.
   */
  RD_STATUS_FILE = 1,
  /**
   * The description of the robot is invalid.
   */
  RD_STATUS_DESCRIPTION = 2,
  /**
   * No frame, pose, quantity or method has the given name.
   */
  RD_STATUS_UNKNOWN_NAME = 3,
  /**
   * An argument is null, has the wrong length, is not finite, is out of its range, or overlaps another.
   */
  RD_STATUS_INVALID_INPUT = 4,
  /**
   * The mass matrix is singular, or the robot is in a singular pose.
   */
  RD_STATUS_SINGULAR = 5,
  /**
   * Constraints are invalid or contradict each other, or the state violates them.
   */
  RD_STATUS_CONSTRAINT = 6,
  /**
   * A motion grew without bound, or a computed number is not finite.
   */
  RD_STATUS_DIVERGED = 7,
  /**
   * An iteration ended before it met its tolerances.
   */
  RD_STATUS_NOT_CONVERGED = 8,
  /**
   * The problem has no solution, or the data do not determine one.
   */
  RD_STATUS_INFEASIBLE = 9,
  /**
   * The method does not support the request.
   */
  RD_STATUS_UNSUPPORTED = 10,
  /**
   * A callback failed.
   */
  RD_STATUS_CALLBACK = 11,
  /**
   * The caller interrupted the computation.
   */
  RD_STATUS_INTERRUPTED = 12,
  /**
   * The system failed: threads or memory.
   */
  RD_STATUS_SYSTEM = 13,
  /**
   * A handle is null, of another kind of object, of a freed object, or of another robot.
   */
  RD_STATUS_INVALID_HANDLE = 14,
  /**
   * Another call uses the object at the same time.
   */
  RD_STATUS_IN_USE = 15,
  /**
   * The library panicked, which is a fault of the library. Free the object of the call.
   */
  RD_STATUS_PANIC = 16,
} rd_status;

/**
 * A quantity of the table. Matrices are row-major.
 */
typedef enum {
  /**
   * M(q), nv × nv.
   */
  RD_QUANTITY_MASS_MATRIX = 0,
  /**
   * C(q, v) v + g(q), nv.
   */
  RD_QUANTITY_BIAS,
  /**
   * g(q), nv.
   */
  RD_QUANTITY_GRAVITY,
  /**
   * C(q, v), nv × nv.
   */
  RD_QUANTITY_CORIOLIS_MATRIX,
  /**
   * C(q, v) v, nv.
   */
  RD_QUANTITY_VELOCITY_PRODUCT,
  /**
   * tau(q, v, a), nv.
   */
  RD_QUANTITY_INVERSE_DYNAMICS,
  /**
   * a(q, v, tau), nv.
   */
  RD_QUANTITY_FORWARD_DYNAMICS,
  /**
   * The inverse of M(q), nv × nv.
   */
  RD_QUANTITY_INVERSE_MASS_MATRIX,
  /**
   * L and D of M(q) = LᵀDL, nv × nv.
   */
  RD_QUANTITY_MASS_MATRIX_FACTOR,
  /**
   * K(q, v).
   */
  RD_QUANTITY_KINETIC_ENERGY,
  /**
   * V(q).
   */
  RD_QUANTITY_POTENTIAL_ENERGY,
  /**
   * M(q) v, nv.
   */
  RD_QUANTITY_MOMENTUM,
  /**
   * The centre of mass in the world, 3.
   */
  RD_QUANTITY_CENTER_OF_MASS,
  /**
   * Its Jacobian, 3 × nv.
   */
  RD_QUANTITY_CENTER_OF_MASS_JACOBIAN,
  /**
   * The centroidal momentum matrix, 6 × nv.
   */
  RD_QUANTITY_CENTROIDAL_MOMENTUM_MATRIX,
  /**
   * Poses of frames, 12 for each: the rotation by rows, then the translation. One state: of all frames.
   * A batch: of the given frames.
   */
  RD_QUANTITY_FRAME_POSES,
  /**
   * A frame's Jacobian, its origin and the world's axes, 6 × nv.
   */
  RD_QUANTITY_FRAME_JACOBIAN_LOCAL_WORLD_ALIGNED,
  /**
   * A frame's Jacobian, its origin and its own axes, 6 × nv.
   */
  RD_QUANTITY_FRAME_JACOBIAN_LOCAL,
  /**
   * A frame's Jacobian, the world's origin and axes, 6 × nv.
   */
  RD_QUANTITY_FRAME_JACOBIAN_WORLD,
  /**
   * ∂tau/∂q and ∂tau/∂v, nv × nv each.
   */
  RD_QUANTITY_INVERSE_DYNAMICS_DERIVATIVES,
  /**
   * ∂a/∂q, ∂a/∂v and ∂a/∂tau, nv × nv each.
   */
  RD_QUANTITY_FORWARD_DYNAMICS_DERIVATIVES,
  /**
   * ∂g/∂q, nv × nv.
   */
  RD_QUANTITY_GRAVITY_DERIVATIVE,
} rd_quantity;

/**
 * The axes and the point of a frame's velocity, acceleration, Jacobian or wrench.
 */
typedef enum {
  /**
   * The world's axes, and the frame's origin.
   */
  RD_REFERENCE_FRAME_LOCAL_WORLD_ALIGNED = 0,
  /**
   * The frame's own axes, and its origin.
   */
  RD_REFERENCE_FRAME_LOCAL = 1,
  /**
   * The world's axes, and the point of the body at the world's origin.
   */
  RD_REFERENCE_FRAME_WORLD = 2,
} rd_reference_frame;

/**
 * The kinds of cost terms, ½ Σ weight · residual².
 */
typedef enum {
  /**
   * x ⊖ target; the target is (q, v), with 2 nv weights.
   */
  RD_COST_KIND_STATE = 0,
  /**
   * u − target, with a weight for each control.
   */
  RD_COST_KIND_CONTROL = 1,
  /**
   * The position of a frame relative to 3 numbers, with 3 weights.
   */
  RD_COST_KIND_FRAME_POSITION = 2,
  /**
   * The pose of a frame relative to 12 numbers, with 6 weights: linear, then angular.
   */
  RD_COST_KIND_FRAME_POSE = 3,
  /**
   * The velocity of a frame's origin along the world's axes, relative to 6 numbers, with 6 weights.
   */
  RD_COST_KIND_FRAME_VELOCITY = 4,
  /**
   * The position of the centre of mass relative to 3 numbers, with 3 weights.
   */
  RD_COST_KIND_CENTER_OF_MASS = 5,
} rd_cost_kind;

/**
 * A robot: immutable, for any number of threads.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_model;

/**
 * Options of loading a robot. A structure filled with zeros selects the defaults.
 */
typedef struct {
  /**
   * Not 0: the base floats, which adds six degrees of freedom.
   */
  int32_t floating_base;
  /**
   * Not 0: warnings are errors.
   */
  int32_t strict;
  /**
   * Not 0: inertias that no rigid body has are repaired, and both values are reported.
   */
  int32_t repair_inertia;
  /**
   * Not 0: other files must be in the folder of the robot's file.
   */
  int32_t confined;
  /**
   * A folder that is searched for `package://NAME/…` before those of `ROS_PACKAGE_PATH`; or null.
   */
  const char *package_path;
  /**
   * The path of the robot's SRDF file; or null.
   */
  const char *srdf;
} rd_load_options;

/**
 * A file in memory.
 */
typedef struct {
  /**
   * The path by which other files name it.
   */
  const char *path;
  /**
   * Its content.
   */
  const uint8_t *content;
  /**
   * The number of bytes.
   */
  size_t length;
} rd_file;

/**
 * A model with the memory and the threads for batches. It serves one call at a time.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_batch;

/**
 * The inputs of a quantity. Those that it does not read may be null. For a batch each array has the rows of
 * all states, one after another.
 */
typedef struct {
  /**
   * The configuration, nq numbers.
   */
  const double *q;
  /**
   * The length of `q`.
   */
  size_t q_len;
  /**
   * The velocity, nv numbers.
   */
  const double *v;
  /**
   * The length of `v`.
   */
  size_t v_len;
  /**
   * The acceleration, nv numbers.
   */
  const double *a;
  /**
   * The length of `a`.
   */
  size_t a_len;
  /**
   * The generalized force, nv numbers.
   */
  const double *tau;
  /**
   * The length of `tau`.
   */
  size_t tau_len;
  /**
   * The numbers of frames.
   */
  const uint32_t *frames;
  /**
   * The length of `frames`.
   */
  size_t frames_len;
} rd_inputs;

/**
 * The arrays of the results of a quantity. Unused ones may be null.
 */
typedef struct {
  /**
   * The first result.
   */
  double *first;
  /**
   * Its length.
   */
  size_t first_len;
  /**
   * The second result.
   */
  double *second;
  /**
   * Its length.
   */
  size_t second_len;
  /**
   * The third result.
   */
  double *third;
  /**
   * Its length.
   */
  size_t third_len;
} rd_results;

/**
 * Constraints of one model, for any number of threads.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_constraints;

/**
 * A model with the memory of its algorithms. It serves one call at a time: make one for each thread.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_workspace;

/**
 * Computed torque: inverse dynamics of a reference with feedback through M.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_computed_torque;

/**
 * An observer of the external torques, from measured states and motor torques.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_momentum_observer;

/**
 * Control of the position or the pose of a frame.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_task_control;

/**
 * A record of measured motions.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_motion_record;

/**
 * Options of inverse kinematics. A structure filled with zeros selects the defaults.
 */
typedef struct {
  /**
   * The allowed distance from the target [m]; 0 for the default, 1e-9.
   */
  double position_tolerance;
  /**
   * The allowed angle from the target [rad]; 0 for the default, 1e-9.
   */
  double angle_tolerance;
  /**
   * The most steps from each start; 0 for the default, 100.
   */
  size_t max_iterations;
  /**
   * The most random starts after the first; 0 for the default, 100.
   */
  size_t max_restarts;
  /**
   * Not 0: no random starts, so that the solution remains near the start.
   */
  int32_t from_start_only;
  /**
   * The seed of the random starts.
   */
  uint64_t seed;
} rd_inverse_kinematics_options;

/**
 * The quality and the cost of a solution.
 */
typedef struct {
  /**
   * The distance from the target [m].
   */
  double position_error;
  /**
   * The angle from the target [rad]; 0 if the orientation is free.
   */
  double angle_error;
  /**
   * The number of steps from all starts.
   */
  size_t iterations;
  /**
   * The number of random starts.
   */
  size_t restarts;
} rd_inverse_kinematics_report;

/**
 * An optimal control problem. The state x is (q, v), the controls u are torques or controls of actuators.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_problem;

/**
 * A simulation of one robot. It serves one call at a time.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_simulation;

/**
 * Options of the solver. A structure filled with zeros selects the defaults.
 */
typedef struct {
  /**
   * The largest number of iterations; 0 for the default, 100.
   */
  size_t max_iterations;
  /**
   * The threads that linearize the nodes; 0 or 1 for the calling thread alone; 1024 are the most.
   */
  size_t threads;
  /**
   * The time after which no iteration starts [s]; 0 for none.
   */
  double time_limit;
  /**
   * The largest derivative of the Lagrangian at a solution; 0 for the default, 1e-6.
   */
  double gradient_tolerance;
} rd_solver_options;

/**
 * A controller that solves a problem again at each period.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_mpc;

/**
 * The times of the periods, without the first [s].
 */
typedef struct {
  /**
   * The number of periods.
   */
  size_t periods;
  /**
   * The median.
   */
  double median;
  /**
   * The time that 99.9 % do not exceed.
   */
  double percentile_99_9;
  /**
   * The longest.
   */
  double longest;
  /**
   * The periods that took longer than the budget.
   */
  size_t over_budget;
} rd_mpc_times_report;

/**
 * The result of a solver.
 */
typedef struct {
  /**
   * Not 0 if the solver ended at a local minimum, to its tolerances or to rounding.
   */
  int32_t is_solved;
  /**
   * The number of iterations.
   */
  size_t iterations;
  /**
   * The cost of the trajectory.
   */
  double cost;
  /**
   * The largest entry of a defect.
   */
  double defect;
  /**
   * The largest derivative of the Lagrangian by an unbounded control.
   */
  double gradient;
} rd_solver_report;

/**
 * Options of a simulation. A structure filled with zeros selects the defaults: everything that the robot's
 * file states, without a ground besides that of the file.
 */
typedef struct {
  /**
   * The step [s]; 0 for the default, 1e-3.
   */
  double dt;
  /**
   * The method, such as `rk4`, `implicit` or `mujoco`; null selects it by the robot.
   */
  const char *method;
  /**
   * Not 0: no effect that removes or adds energy.
   */
  int32_t conservative;
  /**
   * Effects to leave out, separated by commas, such as `dissipation,link-contacts`; or null.
   */
  const char *without;
  /**
   * Not 0: a ground, horizontal at the height `ground_height`.
   */
  int32_t has_ground;
  /**
   * The height of the ground [m].
   */
  double ground_height;
  /**
   * The friction coefficient of the ground; 0 for the default of the file and the library, negative for a
   * ground without friction.
   */
  double ground_friction;
  /**
   * The restitution of the ground, between 0 and 1.
   */
  double ground_restitution;
} rd_simulation_options;

/**
 * The energies of a simulation [J].
 */
typedef struct {
  /**
   * K.
   */
  double kinetic;
  /**
   * V.
   */
  double potential;
  /**
   * K + V at the start.
   */
  double start;
  /**
   * The work of motors and of applied wrenches.
   */
  double work;
  /**
   * The energy that damping, friction and contacts removed.
   */
  double dissipated;
  /**
   * K + V − start − work + dissipated: zero for the exact motion.
   */
  double imbalance;
  /**
   * The largest imbalance relative to the energy that moved.
   */
  double relative_imbalance;
  /**
   * max |E − E₀| relative to the energy that moved.
   */
  double drift;
} rd_energy_account;

/**
 * A contact of two surfaces.
 */
typedef struct {
  /**
   * The frame of the link in contact.
   */
  uint32_t link;
  /**
   * The frame of the other link; `UINT32_MAX` for a ground.
   */
  uint32_t other_link;
  /**
   * The point in the world [m].
   */
  double point[3];
  /**
   * The unit vector that points into `link`, in the world.
   */
  double normal[3];
  /**
   * The distance of the surfaces along the normal, negative where they overlap [m].
   */
  double gap;
  /**
   * The force on `link`, in the world's axes [N].
   */
  double force[3];
  /**
   * The moment on `link` about the point, in the world's axes [N m].
   */
  double moment[3];
} rd_contact;

/**
 * The complete changing state of a simulation.
 */
typedef struct {
  /**
   * The handle; 0 names no object.
   */
  uint64_t id;
} rd_snapshot;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The version of the library: compare it with `RD_VERSION` of the header.
 */
uint32_t rd_version(void);

/**
 * The version of the library's interface: it must equal `RD_ABI_VERSION` of the header.
 */
uint32_t rd_abi_version(void);

/**
 * The text of the last error of the calling thread; empty if there was none. It is valid until the next call
 * of the same thread that fails. It never returns null.
 */
const char *rd_error_message(void);

/**
 * The name of a status, such as `invalid input`; `unknown status` for other numbers. It never returns null.
 */
const char *rd_status_name(int32_t status);

/**
 * The neutral configuration, nq numbers: zeros, and identity quaternions.
 */
rd_status rd_neutral(rd_model model, double *q, size_t nq);

/**
 * A random configuration within the limits, nq numbers; equal seeds give equal configurations.
 */
rd_status rd_random_configuration(rd_model model, uint64_t seed, double *q, size_t nq);

/**
 * The configuration and the velocity of a named pose of the robot's files.
 */
rd_status rd_named_pose(rd_model model, const char *name, double *q, size_t nq, double *v, size_t nv);

/**
 * moved = q ⊕ displacement: along a velocity for one second. Does not allocate.
 */
rd_status rd_integrate(rd_model model,
                       const double *q,
                       size_t nq,
                       const double *displacement,
                       size_t nv,
                       double *moved,
                       size_t moved_len);

/**
 * displacement = q1 ⊖ q0, so that q0 ⊕ displacement = q1. Does not allocate.
 */
rd_status rd_difference(rd_model model,
                        const double *q0,
                        size_t q0_len,
                        const double *q1,
                        size_t q1_len,
                        double *displacement,
                        size_t nv);

/**
 * The configuration between q0 (s = 0) and q1 (s = 1), along the shortest path. Allocates.
 */
rd_status rd_interpolate(rd_model model,
                         const double *q0,
                         size_t q0_len,
                         const double *q1,
                         size_t q1_len,
                         double s,
                         double *between,
                         size_t nq);

/**
 * Scales the quaternions in q to unit length, in place. A quaternion of zeros is an error.
 */
rd_status rd_normalize(rd_model model, double *q, size_t nq);

/**
 * Loads a robot from a URDF, MJCF, SDF, USD or scene file. `options` may be null. Suspicious values are
 * taken as written and reported: see `rd_model_report`. Free the model with `rd_model_free`.
 */
rd_status rd_load(const char *path, const rd_load_options *options, rd_model *model);

/**
 * Loads a robot from the text of its file. `options` may be null.
 */
rd_status rd_load_text(const char *content, const rd_load_options *options, rd_model *model);

/**
 * Loads a robot from files in memory. `path` names the main file among them. `options` may be null.
 */
rd_status rd_load_files(const rd_file *files,
                        size_t file_count,
                        const char *path,
                        const rd_load_options *options,
                        rd_model *model);

/**
 * Frees a model. Workspaces, simulations and other objects of it remain valid. The null handle is ignored.
 */
rd_status rd_model_free(rd_model model);

/**
 * The number of coordinates of a configuration q; 0 if the handle is invalid.
 */
size_t rd_model_nq(rd_model model);

/**
 * The number of degrees of freedom: the length of v, a and tau; 0 if the handle is invalid.
 */
size_t rd_model_nv(rd_model model);

/**
 * The number of joints; 0 if the handle is invalid.
 */
size_t rd_model_joint_count(rd_model model);

/**
 * The number of frames; 0 if the handle is invalid. Every link is a frame.
 */
size_t rd_model_frame_count(rd_model model);

/**
 * The number of named poses in the robot's files; 0 if the handle is invalid.
 */
size_t rd_model_pose_count(rd_model model);

/**
 * The robot's name; null if the handle is invalid. This and the other texts of a model are valid until it is
 * freed.
 */
const char *rd_model_name(rd_model model);

/**
 * The report of the loader: everything that was read, defaulted, suspicious or ignored, by line.
 */
const char *rd_model_report(rd_model model);

/**
 * The name of a joint by its number; null for any other number.
 */
const char *rd_model_joint_name(rd_model model, size_t joint);

/**
 * The name of a coordinate of v by its number; null for any other number.
 */
const char *rd_model_coordinate_name(rd_model model, size_t coordinate);

/**
 * The name of a frame by its number; null for any other number.
 */
const char *rd_model_frame_name(rd_model model, uint32_t frame);

/**
 * The name of a pose by its number; null for any other number.
 */
const char *rd_model_pose_name(rd_model model, size_t pose);

/**
 * The number of the frame with this name.
 */
rd_status rd_model_frame(rd_model model, const char *name, uint32_t *frame);

/**
 * The places of a joint's coordinates: the first index in q and in v, and their numbers.
 */
rd_status rd_model_joint_indices(rd_model model,
                                 size_t joint,
                                 size_t *q_index,
                                 size_t *nq,
                                 size_t *v_index,
                                 size_t *nv);

/**
 * The lower position limit of each coordinate, nv numbers [rad or m]; −∞ without a limit.
 */
rd_status rd_model_lower_limits(rd_model model, double *out, size_t len);

/**
 * The upper position limit of each coordinate, nv numbers [rad or m]; ∞ without a limit.
 */
rd_status rd_model_upper_limits(rd_model model, double *out, size_t len);

/**
 * The velocity limit of each coordinate, nv numbers [rad/s or m/s]; ∞ without a limit.
 */
rd_status rd_model_velocity_limits(rd_model model, double *out, size_t len);

/**
 * The effort limit of each coordinate, nv numbers [N m or N]; ∞ without a limit.
 */
rd_status rd_model_effort_limits(rd_model model, double *out, size_t len);

/**
 * The mass of the moving bodies [kg]; NaN if the handle is invalid.
 */
double rd_model_mass(rd_model model);

/**
 * The gravitational acceleration in the world, three numbers [m/s²].
 */
rd_status rd_model_gravity(rd_model model, double *out, size_t len);

/**
 * A hash of the description: equal for two models if every name and every digit is; 0 if the handle is
 * invalid.
 */
uint64_t rd_model_fingerprint(rd_model model);

/**
 * Makes a batch of a model. 0 threads select one for each core, 1 the calling thread alone; 1024 are the
 * most. Free it with `rd_batch_free`.
 */
rd_status rd_batch_new(rd_model model, size_t threads, rd_batch *batch);

/**
 * Frees a batch. The null handle is ignored.
 */
rd_status rd_batch_free(rd_batch batch);

/**
 * Computes a quantity of `states` states. Each array has the rows of all states, one after another; all
 * states share the frames. If a state is invalid, an error names it, and the results of the others are
 * valid.
 *
 * Quantities without a form for batches are computed one state after another. With one thread the call does
 * not allocate.
 */
rd_status rd_batch_compute(rd_batch batch,
                           uint32_t quantity,
                           size_t states,
                           const rd_inputs *inputs,
                           const rd_results *results);

/**
 * The loops, couplings and other equalities of the robot's file. Free them with `rd_constraints_free`.
 */
rd_status rd_constraints_from_file(rd_model model, rd_constraints *constraints);

/**
 * Supports that hold the origins of frames where they are. `points` has 3 numbers for each frame, its
 * position in the world [m]. Free them with `rd_constraints_free`.
 */
rd_status rd_constraints_at_points(rd_model model,
                                   const uint32_t *frames,
                                   size_t frame_count,
                                   const double *points,
                                   size_t points_len,
                                   rd_constraints *constraints);

/**
 * Supports that hold the poses of frames. `poses` has 12 numbers for each frame, its pose in the world. Free
 * them with `rd_constraints_free`.
 */
rd_status rd_constraints_at_poses(rd_model model,
                                  const uint32_t *frames,
                                  size_t frame_count,
                                  const double *poses,
                                  size_t poses_len,
                                  rd_constraints *constraints);

/**
 * Frees constraints. The null handle is ignored.
 */
rd_status rd_constraints_free(rd_constraints constraints);

/**
 * The number of rows; 0 if the handle is invalid.
 */
size_t rd_constraints_row_count(rd_constraints constraints);

/**
 * The name of a row; null for any other number. It is valid until the constraints are freed.
 */
const char *rd_constraints_row_name(rd_constraints constraints, size_t row);

/**
 * a and the multipliers lambda of M a + C v + g = tau + Aᵀ lambda with A a = −Ȧ v. Dependent rows are left
 * out. `multipliers` has one number for each row. Allocates.
 */
rd_status rd_constrained_forward_dynamics(rd_workspace workspace,
                                          rd_constraints constraints,
                                          const double *q,
                                          size_t nq,
                                          const double *v,
                                          size_t nv,
                                          const double *tau,
                                          size_t tau_len,
                                          double *a,
                                          size_t a_len,
                                          double *multipliers,
                                          size_t multipliers_len);

/**
 * Moves q, in place, to the nearest configuration that meets the constraints to a tolerance. Allocates.
 */
rd_status rd_project_position(rd_workspace workspace,
                              rd_constraints constraints,
                              double tolerance,
                              double *q,
                              size_t nq);

/**
 * Makes tau = M(a* + Kp (q* ⊖ q) + Kd (v* − v)) + C v + g, with nv gains each. The reference is the neutral
 * configuration at rest until `rd_computed_torque_set_reference`. `dissipation`: not 0 compensates damping
 * and friction of the joints. Free it with `rd_computed_torque_free`.
 */
rd_status rd_computed_torque_new(rd_model model,
                                 const double *stiffness,
                                 size_t stiffness_len,
                                 const double *damping,
                                 size_t damping_len,
                                 int32_t dissipation,
                                 rd_computed_torque *controller);

/**
 * Frees a controller. The null handle is ignored.
 */
rd_status rd_computed_torque_free(rd_computed_torque controller);

/**
 * Sets the reference: q* (nq numbers), v* and a* (nv each). Does not allocate.
 */
rd_status rd_computed_torque_set_reference(rd_computed_torque controller,
                                           const double *q,
                                           size_t nq,
                                           const double *v,
                                           size_t nv,
                                           const double *a,
                                           size_t a_len);

/**
 * The torque at a state, nv numbers. Does not allocate.
 */
rd_status rd_computed_torque_torque(rd_computed_torque controller,
                                    const double *q,
                                    size_t nq,
                                    const double *v,
                                    size_t nv,
                                    double *tau,
                                    size_t tau_len);

/**
 * The gain K, m × n, of u = −K x that minimizes Σ xᵀQ x + uᵀR u along x' = A x + B u. A and Q are n × n, B
 * is n × m, R is m × m, all row-major. `spectral_radius` may be null: the largest |λ| of A − B K. Allocates.
 */
rd_status rd_dlqr(size_t states,
                  size_t controls,
                  const double *a,
                  const double *b,
                  const double *q,
                  const double *r,
                  double *gain,
                  size_t gain_len,
                  double *spectral_radius);

/**
 * Makes an observer with nv gains [1/s]. `dissipation`: not 0 counts damping and friction as known. Free
 * it with `rd_momentum_observer_free`.
 */
rd_status rd_momentum_observer_new(rd_model model,
                                   const double *gains,
                                   size_t gains_len,
                                   int32_t dissipation,
                                   rd_momentum_observer *observer);

/**
 * Frees an observer. The null handle is ignored.
 */
rd_status rd_momentum_observer_free(rd_momentum_observer observer);

/**
 * Enters a sample, h seconds after the last one, and copies the estimated external torques, nv numbers. Does
 * not allocate.
 */
rd_status rd_momentum_observer_update(rd_momentum_observer observer,
                                      const double *q,
                                      size_t nq,
                                      const double *v,
                                      size_t nv,
                                      const double *tau,
                                      size_t tau_len,
                                      double h,
                                      double *external,
                                      size_t external_len);

/**
 * Forgets all samples.
 */
rd_status rd_momentum_observer_reset(rd_momentum_observer observer);

/**
 * Makes a controller of a frame: of its position (`has_orientation` 0) or of its pose. The gains are kp
 * [1/s²], kd [1/s] and the damping of the null space [1/s]. `posture` has nq numbers, or is null; its
 * stiffness is in [1/s²]. The torque is within the effort limits of the robot. Free it with
 * `rd_task_control_free`.
 */
rd_status rd_task_control_new(rd_model model,
                              uint32_t frame,
                              int32_t has_orientation,
                              double stiffness,
                              double damping,
                              double null_damping,
                              const double *posture,
                              size_t posture_len,
                              double posture_stiffness,
                              rd_task_control *controller);

/**
 * Frees a controller. The null handle is ignored.
 */
rd_status rd_task_control_free(rd_task_control controller);

/**
 * Sets the target: 12 numbers of a pose, or 3 of a position; its velocity and its acceleration along the
 * world's axes, 6 numbers each, or null at rest. Does not allocate.
 */
rd_status rd_task_control_set_target(rd_task_control controller,
                                     const double *target,
                                     size_t target_len,
                                     const double *velocity,
                                     size_t velocity_len,
                                     const double *acceleration,
                                     size_t acceleration_len);

/**
 * The torque at a state, nv numbers. Does not allocate.
 */
rd_status rd_task_control_torque(rd_task_control controller,
                                 const double *q,
                                 size_t nq,
                                 const double *v,
                                 size_t nv,
                                 double *tau,
                                 size_t tau_len);

/**
 * The pose of a frame in the world, 12 numbers: the rotation by rows, then the translation [m]. Does not
 * allocate.
 */
rd_status rd_frame_pose(rd_workspace workspace,
                        uint32_t frame,
                        const double *q,
                        size_t nq,
                        double *pose,
                        size_t pose_len);

/**
 * The velocity of a frame, linear then angular, 6 numbers [m/s, rad/s]. Does not allocate.
 */
rd_status rd_frame_velocity(rd_workspace workspace,
                            uint32_t frame,
                            uint32_t reference,
                            const double *q,
                            size_t nq,
                            const double *v,
                            size_t nv,
                            double *velocity,
                            size_t velocity_len);

/**
 * The time derivative of `rd_frame_velocity`'s numbers, linear then angular, 6 numbers [m/s², rad/s²].
 * Does not allocate.
 */
rd_status rd_frame_acceleration(rd_workspace workspace,
                                uint32_t frame,
                                uint32_t reference,
                                const double *q,
                                size_t nq,
                                const double *v,
                                size_t nv,
                                const double *a,
                                size_t a_len,
                                double *acceleration,
                                size_t acceleration_len);

/**
 * J with J v = `rd_frame_velocity`, 6 × nv, row-major: linear rows, then angular ones. Does not allocate.
 */
rd_status rd_frame_jacobian(rd_workspace workspace,
                            uint32_t frame,
                            uint32_t reference,
                            const double *q,
                            size_t nq,
                            double *jacobian,
                            size_t jacobian_len);

/**
 * J̇ v, the acceleration of a frame at a = 0, 6 numbers. Does not allocate.
 */
rd_status rd_frame_bias_acceleration(rd_workspace workspace,
                                     uint32_t frame,
                                     uint32_t reference,
                                     const double *q,
                                     size_t nq,
                                     const double *v,
                                     size_t nv,
                                     double *acceleration,
                                     size_t acceleration_len);

/**
 * The velocity of the centre of mass, 3 numbers [m/s]. Does not allocate.
 */
rd_status rd_center_of_mass_velocity(rd_workspace workspace,
                                     const double *q,
                                     size_t nq,
                                     const double *v,
                                     size_t nv,
                                     double *velocity,
                                     size_t velocity_len);

/**
 * The wrench that each joint transmits to its child link, 6 numbers for each joint, without contacts:
 * force [N] and moment [N m], in the axes and about the origin of the child link. Does not allocate.
 */
rd_status rd_joint_reactions(rd_workspace workspace,
                             const double *q,
                             size_t nq,
                             const double *v,
                             size_t nv,
                             const double *a,
                             size_t a_len,
                             double *reactions,
                             size_t reactions_len);

/**
 * Y with tau = Y p, nv × 10 links, row-major; p are the inertial parameters of `rd_inertial_parameters`.
 * Does not allocate.
 */
rd_status rd_joint_torque_regressor(rd_workspace workspace,
                                    const double *q,
                                    size_t nq,
                                    const double *v,
                                    size_t nv,
                                    const double *a,
                                    size_t a_len,
                                    double *regressor,
                                    size_t regressor_len);

/**
 * The inertial parameters of the moving links, ten for each: the mass [kg], the first moment (3) [kg m],
 * and xx, xy, yy, xz, yz, zz of the inertia about the link's origin [kg m²].
 */
rd_status rd_inertial_parameters(rd_workspace workspace, double *parameters, size_t parameters_len);

/**
 * The number of inertial parameters of the moving links; 0 if the handle is invalid.
 */
size_t rd_inertial_parameter_count(rd_workspace workspace);

/**
 * Makes an empty record. `dissipation`: not 0 if the torques include damping and friction of the model.
 * `joint_terms`: bits of `RD_TERM_…`. Free it with `rd_motion_record_free`.
 */
rd_status rd_motion_record_new(rd_model model,
                               int32_t dissipation,
                               uint32_t joint_terms,
                               rd_motion_record *record);

/**
 * Frees a record. The null handle is ignored.
 */
rd_status rd_motion_record_free(rd_motion_record record);

/**
 * States the standard deviation of the noise of each torque, nv positive numbers [N m or N].
 */
rd_status rd_motion_record_set_noise(rd_motion_record record,
                                     const double *deviations,
                                     size_t deviations_len);

/**
 * Adds a sample: a state, its acceleration and the measured torque. Allocates.
 */
rd_status rd_motion_record_push(rd_motion_record record,
                                const double *q,
                                size_t nq,
                                const double *v,
                                size_t nv,
                                const double *a,
                                size_t a_len,
                                const double *tau,
                                size_t tau_len);

/**
 * The number of parameters of a record: inertial ones and joint terms; 0 if the handle is invalid.
 */
size_t rd_motion_record_parameter_count(rd_motion_record record);

/**
 * The name of a parameter, such as `forearm.m`; null for any other number. It is valid until the record is
 * freed.
 */
const char *rd_motion_record_parameter_name(rd_motion_record record, size_t parameter);

/**
 * Estimates the base parameters by least squares: the combinations that the motions determine.
 *
 * For base parameter k, `indices[k]` is the number of the parameter that names it, `values[k]` its value and
 * `deviations[k]` its standard deviation. The arrays have room for `capacity` numbers each; `count` is the
 * number of base parameters. `residual` is the root mean square of the torques' errors. Allocates.
 */
rd_status rd_identify(rd_motion_record record,
                      uint32_t *indices,
                      double *values,
                      double *deviations,
                      size_t capacity,
                      size_t *count,
                      double *residual);

/**
 * Estimates parameters with which every link is a possible body. `regularization` weighs the distance from
 * the described robot, 1e-3 for example. `parameters` has one number for each parameter of the record.
 * `model` may be null; else it is the robot with these parameters. Allocates.
 */
rd_status rd_identify_consistent(rd_motion_record record,
                                 double regularization,
                                 double *parameters,
                                 size_t parameters_len,
                                 double *residual,
                                 rd_model *model);

/**
 * Finds a configuration within the limits in which a frame reaches a target, near the start.
 *
 * `target` has 12 numbers for a pose (the rotation by rows, then the translation), or 3 for a position.
 * `options` and `report` may be null. Without a solution the status is `RD_STATUS_NOT_CONVERGED`, and q is
 * the nearest configuration that was found. Allocates.
 */
rd_status rd_inverse_kinematics(rd_workspace workspace,
                                uint32_t frame,
                                const double *target,
                                size_t target_len,
                                const double *start,
                                size_t start_len,
                                const rd_inverse_kinematics_options *options,
                                double *q,
                                size_t nq,
                                rd_inverse_kinematics_report *report);

/**
 * A = ∂(q₁, v₁)/∂(q₀, v₀), 2nv × 2nv, and B = ∂(q₁, v₁)/∂tau, 2nv × nv, row-major, of a step without contact
 * by an integrator such as `rk4` or `semi-implicit-euler`. `dissipation`: not 0 for damping and friction.
 * Allocates.
 */
rd_status rd_linearize_step(rd_workspace workspace,
                            const char *integrator,
                            double dt,
                            int32_t dissipation,
                            const double *q,
                            size_t nq,
                            const double *v,
                            size_t nv,
                            const double *tau,
                            size_t tau_len,
                            double *by_state,
                            size_t by_state_len,
                            double *by_force,
                            size_t by_force_len);

/**
 * Makes a problem of N nodes from steps without contact, by an integrator such as `rk4`. The controls are
 * the torques of the driven coordinates. `state` is x₀ = (q, v), nq + nv numbers. N is at most 2²⁰. Free it
 * with `rd_problem_free`.
 */
rd_status rd_problem_new(rd_model model,
                         const char *integrator,
                         double dt,
                         int32_t dissipation,
                         size_t nodes,
                         const double *state,
                         size_t state_len,
                         rd_problem *problem);

/**
 * Makes a problem of N nodes from the steps of a simulation, with contact, stops and friction. The controls
 * are the torques of the driven coordinates, or the controls of the actuators if `actuators` is not 0.
 * `state` is x₀ = (q, v). N is at most 2²⁰.
 */
rd_status rd_problem_from_simulation(rd_simulation simulation,
                                     int32_t actuators,
                                     size_t nodes,
                                     const double *state,
                                     size_t state_len,
                                     rd_problem *problem);

/**
 * Frees a problem. The null handle is ignored.
 */
rd_status rd_problem_free(rd_problem problem);

/**
 * The number of controls of each node; 0 if the handle is invalid.
 */
size_t rd_problem_control_count(rd_problem problem);

/**
 * Adds a cost term of a kind of `rd_cost_kind` to the nodes from `first` to `end` − 1; node N is the last
 * state. `frame` counts only for frames. Costs of the controls end at node N − 1.
 */
rd_status rd_problem_add_cost(rd_problem problem,
                              uint32_t kind,
                              size_t first,
                              size_t end,
                              uint32_t frame,
                              const double *target,
                              size_t target_len,
                              const double *weights,
                              size_t weights_len);

/**
 * Removes all cost terms, to add those of another target.
 */
rd_status rd_problem_clear_costs(rd_problem problem);

/**
 * Bounds the controls of the nodes from `first` to `end` − 1.
 */
rd_status rd_problem_set_control_bounds(rd_problem problem,
                                        size_t first,
                                        size_t end,
                                        const double *lower,
                                        size_t lower_len,
                                        const double *upper,
                                        size_t upper_len);

/**
 * Sets x₀ = (q, v).
 */
rd_status rd_problem_set_initial_state(rd_problem problem, const double *state, size_t state_len);

/**
 * Makes a controller of a problem, with its present costs and bounds. One period is one node. `options` may
 * be null. `iterations` is the most of each period, 0 for the default, 2. `time_budget` is that of a period
 * [s], 0 for none. Free it with `rd_mpc_free`.
 */
rd_status rd_mpc_new(rd_problem problem,
                     const rd_solver_options *options,
                     size_t iterations,
                     double time_budget,
                     rd_mpc *mpc);

/**
 * Frees a controller. The null handle is ignored.
 */
rd_status rd_mpc_free(rd_mpc mpc);

/**
 * The controls of the next period, from the measured state (q, v). Allocates.
 */
rd_status rd_mpc_step(rd_mpc mpc, const double *state, size_t state_len, double *control, size_t control_len);

/**
 * Takes the present costs of a problem, for example with another target. The problem must be the one from
 * which the controller was made, or have as many nodes and controls.
 */
rd_status rd_mpc_set_costs(rd_mpc mpc, rd_problem problem);

/**
 * The times of the periods so far.
 */
rd_status rd_mpc_times(rd_mpc mpc, rd_mpc_times_report *times);

/**
 * Solves the problem by FDDP, from zero controls or from the last solution. `options` and `report` may be
 * null. If the solver ends elsewhere than at a minimum, the status is `RD_STATUS_NOT_CONVERGED`, and the
 * trajectory is the best that was found. Allocates.
 */
rd_status rd_problem_solve(rd_problem problem, const rd_solver_options *options, rd_solver_report *report);

/**
 * The state (q, v) of a node of the solution, nq + nv numbers; node N is the last.
 */
rd_status rd_problem_state(rd_problem problem, size_t node, double *state, size_t state_len);

/**
 * The controls of a node of the solution.
 */
rd_status rd_problem_control(rd_problem problem, size_t node, double *control, size_t control_len);

/**
 * The gain K of u = u_k + K (x ⊖ x_k) at a node, controls × 2 nv, row-major.
 */
rd_status rd_problem_gain(rd_problem problem, size_t node, double *gain, size_t gain_len);

/**
 * Computes a quantity of the table for one state. Does not allocate.
 *
 * The lengths of unused arrays must be 0.
 */
rd_status rd_compute(rd_workspace workspace,
                     uint32_t quantity,
                     const rd_inputs *inputs,
                     const rd_results *results);

/**
 * The number of quantities in the table.
 */
uint32_t rd_quantity_count(void);

/**
 * The number of the quantity with this name, such as `mass_matrix`.
 */
rd_status rd_quantity_named(const char *name, uint32_t *quantity);

/**
 * The lengths of the three results of a quantity for one state, 0 for those that it does not have.
 */
rd_status rd_quantity_lengths(rd_workspace workspace,
                              uint32_t quantity,
                              size_t frame_count,
                              size_t *lengths,
                              size_t lengths_len);

/**
 * The name of a quantity; null for any other number.
 */
const char *rd_quantity_name(uint32_t quantity);

/**
 * M(q), nv × nv, row-major. Does not allocate.
 */
rd_status rd_mass_matrix(rd_workspace workspace, const double *q, size_t nq, double *mass, size_t mass_len);

/**
 * The inverse of M(q), nv × nv, row-major. Does not allocate.
 */
rd_status rd_inverse_mass_matrix(rd_workspace workspace,
                                 const double *q,
                                 size_t nq,
                                 double *inverse,
                                 size_t inverse_len);

/**
 * L and D of M(q) = LᵀDL, nv × nv, row-major: D on the diagonal, L below it. Does not allocate.
 */
rd_status rd_mass_matrix_factor(rd_workspace workspace,
                                const double *q,
                                size_t nq,
                                double *factor,
                                size_t factor_len);

/**
 * g(q), nv numbers, springs included. Does not allocate.
 */
rd_status rd_gravity(rd_workspace workspace, const double *q, size_t nq, double *g, size_t g_len);

/**
 * ∂g/∂q, nv × nv, row-major. Does not allocate.
 */
rd_status rd_gravity_derivative(rd_workspace workspace,
                                const double *q,
                                size_t nq,
                                double *derivative,
                                size_t derivative_len);

/**
 * C(q, v) v + g(q), nv numbers. Does not allocate.
 */
rd_status rd_bias(rd_workspace workspace,
                  const double *q,
                  size_t nq,
                  const double *v,
                  size_t nv,
                  double *bias,
                  size_t bias_len);

/**
 * C(q, v) of the Christoffel symbols, nv × nv, row-major. Does not allocate.
 */
rd_status rd_coriolis_matrix(rd_workspace workspace,
                             const double *q,
                             size_t nq,
                             const double *v,
                             size_t nv,
                             double *coriolis,
                             size_t coriolis_len);

/**
 * C(q, v) v, nv numbers. Does not allocate.
 */
rd_status rd_velocity_product(rd_workspace workspace,
                              const double *q,
                              size_t nq,
                              const double *v,
                              size_t nv,
                              double *product,
                              size_t product_len);

/**
 * M(q) v, nv numbers. Does not allocate.
 */
rd_status rd_momentum(rd_workspace workspace,
                      const double *q,
                      size_t nq,
                      const double *v,
                      size_t nv,
                      double *momentum,
                      size_t momentum_len);

/**
 * K(q, v) [J]. Does not allocate.
 */
rd_status rd_kinetic_energy(rd_workspace workspace,
                            const double *q,
                            size_t nq,
                            const double *v,
                            size_t nv,
                            double *energy);

/**
 * V(q) [J]. Does not allocate.
 */
rd_status rd_potential_energy(rd_workspace workspace, const double *q, size_t nq, double *energy);

/**
 * tau = M(q) a + C(q, v) v + g(q), nv numbers [N m or N]. Does not allocate.
 */
rd_status rd_inverse_dynamics(rd_workspace workspace,
                              const double *q,
                              size_t nq,
                              const double *v,
                              size_t nv,
                              const double *a,
                              size_t a_len,
                              double *tau,
                              size_t tau_len);

/**
 * a = M(q)⁻¹(tau − C(q, v) v − g(q)), nv numbers [rad/s² or m/s²]. Does not allocate.
 */
rd_status rd_forward_dynamics(rd_workspace workspace,
                              const double *q,
                              size_t nq,
                              const double *v,
                              size_t nv,
                              const double *tau,
                              size_t tau_len,
                              double *a,
                              size_t a_len);

/**
 * ∂tau/∂q and ∂tau/∂v of tau(q, v, a), nv × nv each, row-major. Derivatives by q are along
 * `rd_integrate`. ∂tau/∂a is `rd_mass_matrix`. Does not allocate.
 */
rd_status rd_inverse_dynamics_derivatives(rd_workspace workspace,
                                          const double *q,
                                          size_t nq,
                                          const double *v,
                                          size_t nv,
                                          const double *a,
                                          size_t a_len,
                                          double *by_position,
                                          size_t by_position_len,
                                          double *by_velocity,
                                          size_t by_velocity_len);

/**
 * ∂a/∂q, ∂a/∂v and ∂a/∂tau of a(q, v, tau), nv × nv each, row-major. Does not allocate.
 */
rd_status rd_forward_dynamics_derivatives(rd_workspace workspace,
                                          const double *q,
                                          size_t nq,
                                          const double *v,
                                          size_t nv,
                                          const double *tau,
                                          size_t tau_len,
                                          double *by_position,
                                          size_t by_position_len,
                                          double *by_velocity,
                                          size_t by_velocity_len,
                                          double *by_force,
                                          size_t by_force_len);

/**
 * The centre of mass in the world, 3 numbers [m]. Does not allocate.
 */
rd_status rd_center_of_mass(rd_workspace workspace,
                            const double *q,
                            size_t nq,
                            double *center,
                            size_t center_len);

/**
 * The Jacobian of the centre of mass, 3 × nv, row-major. Does not allocate.
 */
rd_status rd_center_of_mass_jacobian(rd_workspace workspace,
                                     const double *q,
                                     size_t nq,
                                     double *jacobian,
                                     size_t jacobian_len);

/**
 * The centroidal momentum matrix, 6 × nv, row-major: linear rows, then angular ones. Does not allocate.
 */
rd_status rd_centroidal_momentum_matrix(rd_workspace workspace,
                                        const double *q,
                                        size_t nq,
                                        double *matrix,
                                        size_t matrix_len);

/**
 * The poses of all frames in the world, 12 numbers each: the rotation by rows, then the translation. Does
 * not allocate.
 */
rd_status rd_frame_poses(rd_workspace workspace, const double *q, size_t nq, double *poses, size_t poses_len);

/**
 * Makes a simulation of a model at its initial configuration, at rest. `options` may be null. Free it with
 * `rd_simulation_free`.
 */
rd_status rd_simulation_new(rd_model model, const rd_simulation_options *options, rd_simulation *simulation);

/**
 * Frees a simulation. The null handle is ignored.
 */
rd_status rd_simulation_free(rd_simulation simulation);

/**
 * The name of the method that takes the steps. This and the other texts of a simulation are valid until it
 * is freed.
 */
const char *rd_simulation_method(rd_simulation simulation);

/**
 * The reason why the library selected this method.
 */
const char *rd_simulation_reason(rd_simulation simulation);

/**
 * The features of the robot's file that the simulation leaves out, one in a line; empty if there are none.
 */
const char *rd_simulation_left_out(rd_simulation simulation);

/**
 * The number of actuators, the length of the controls; 0 if the handle is invalid.
 */
size_t rd_simulation_control_count(rd_simulation simulation);

/**
 * The name of an actuator; null for any other number.
 */
const char *rd_simulation_control_name(rd_simulation simulation, size_t control);

/**
 * The time [s]; NaN if the handle is invalid.
 */
double rd_simulation_time(rd_simulation simulation);

/**
 * Takes steps. It stops at the first one that fails; the state is then that before the failed step. A step
 * without a ground and contacts does not allocate.
 */
rd_status rd_simulation_step(rd_simulation simulation, size_t steps);

/**
 * The configuration, nq numbers. Does not allocate.
 */
rd_status rd_simulation_q(rd_simulation simulation, double *q, size_t nq);

/**
 * The velocity, nv numbers. Does not allocate.
 */
rd_status rd_simulation_v(rd_simulation simulation, double *v, size_t nv);

/**
 * The mean acceleration of the last step, nv numbers. Does not allocate.
 */
rd_status rd_simulation_acceleration(rd_simulation simulation, double *a, size_t nv);

/**
 * The generalized forces that acted in the last step, after effort limits, nv numbers. Does not allocate.
 */
rd_status rd_simulation_applied_torques(rd_simulation simulation, double *tau, size_t nv);

/**
 * The energy account. Does not allocate.
 */
rd_status rd_simulation_energy(rd_simulation simulation, rd_energy_account *energy);

/**
 * The contacts of the last step. At most `capacity` are written; `count` is the number of all. Allocates.
 */
rd_status rd_simulation_contacts(rd_simulation simulation,
                                 rd_contact *contacts,
                                 size_t capacity,
                                 size_t *count);

/**
 * Sets the state, and time and energy account to their start.
 */
rd_status rd_simulation_reset(rd_simulation simulation,
                              const double *q,
                              size_t nq,
                              const double *v,
                              size_t nv);

/**
 * Resets the state to a named pose of the robot's files.
 */
rd_status rd_simulation_reset_to(rd_simulation simulation, const char *pose);

/**
 * Sets the state; the time goes on.
 */
rd_status rd_simulation_set_state(rd_simulation simulation,
                                  const double *q,
                                  size_t nq,
                                  const double *v,
                                  size_t nv);

/**
 * Sets the torques of the next steps, nv numbers [N m or N]. Does not allocate.
 */
rd_status rd_simulation_set_torques(rd_simulation simulation, const double *tau, size_t nv);

/**
 * Sets the controls of the actuators for the next steps. Does not allocate.
 */
rd_status rd_simulation_set_controls(rd_simulation simulation, const double *controls, size_t count);

/**
 * Sets the wrenches on frames for the next steps, in place of all earlier ones. `references` has a reference
 * frame for each, `wrenches` six numbers: force [N] and moment [N m]. Does not allocate for as many
 * wrenches as an earlier call.
 */
rd_status rd_simulation_set_wrenches(rd_simulation simulation,
                                     const uint32_t *frames,
                                     const uint32_t *references,
                                     size_t count,
                                     const double *wrenches,
                                     size_t wrenches_len);

/**
 * The number of sensors; 0 if the handle is invalid.
 */
size_t rd_simulation_sensor_count(rd_simulation simulation);

/**
 * The name of a sensor; null for any other number.
 */
const char *rd_simulation_sensor_name(rd_simulation simulation, size_t sensor);

/**
 * The place of a sensor's values in `rd_simulation_sensors`: the first one and their number.
 */
rd_status rd_simulation_sensor_range(rd_simulation simulation, size_t sensor, size_t *first, size_t *count);

/**
 * The number of values of all sensors; 0 if the handle is invalid.
 */
size_t rd_simulation_sensor_value_count(rd_simulation simulation);

/**
 * The values of all sensors at the end of the last step, in the order of the file. Allocates.
 */
rd_status rd_simulation_sensors(rd_simulation simulation, double *values, size_t values_len);

/**
 * Copies the complete changing state. Free the snapshot with `rd_snapshot_free`.
 */
rd_status rd_simulation_snapshot(rd_simulation simulation, rd_snapshot *snapshot);

/**
 * Restores a snapshot of this simulation, bit for bit.
 */
rd_status rd_simulation_restore(rd_simulation simulation, rd_snapshot snapshot);

/**
 * Frees a snapshot. The null handle is ignored.
 */
rd_status rd_snapshot_free(rd_snapshot snapshot);

/**
 * Makes a workspace of a model. Free it with `rd_workspace_free`.
 */
rd_status rd_workspace_new(rd_model model, rd_workspace *workspace);

/**
 * Frees a workspace. The null handle is ignored.
 */
rd_status rd_workspace_free(rd_workspace workspace);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* ROBOT_DYNAMICS_H */
