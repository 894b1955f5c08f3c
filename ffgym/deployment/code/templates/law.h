/* $title
 *
 * Feed-forward law $law of robot $robot, $scope.
 * Written by ffgym $version. C99 and its math library; no allocation, no input or output, no global state.
 * $checked
 *
 * A drive that takes a torque beside its own control calls `${name}_start` once, then `${name}_step` every control step
 * of $dt s. What a step gets and gives is motor side, but for q:
 *
 *     q          joint positions of the reference, link side [rad, or m for a slide]
 *     motor_dq   motor speeds of the reference [rad/s]
 *     motor_ddq  motor accelerations of the reference [rad/s^2]
 *     torque     torque to add [N m]; computed at sample k, it is to be reached at sample k + 1
 *
 * Each of the first three holds samples k, k + 1, ... k + $preview of the reference, joint by joint: sample i of joint j
 * stands at [i * ${upper}_JOINTS + j]. Beyond the end of the motion its last sample holds.
 */
#ifndef ${upper}_H
#define ${upper}_H

#define ${upper}_JOINTS $joints
#define ${upper}_PREVIEW $preview
#define ${upper}_WINDOW ((${upper}_PREVIEW + 1) * ${upper}_JOINTS)
#define ${upper}_MEMORY $memory
#define ${upper}_SAMPLES $samples
#define ${upper}_DT $dt

typedef struct {
    double memory[${upper}_MEMORY];
    unsigned long step; /* steps of the motion that are done */
} ${name}_state;

/* Sets the state to the start of the motion, where the robot rests. */
void ${name}_start(${name}_state *state);

/* Computes the torque of the next sample, and advances the state. Returns 0.$end */
int ${name}_step(${name}_state *state, const double q[${upper}_WINDOW], const double motor_dq[${upper}_WINDOW],
    const double motor_ddq[${upper}_WINDOW], double torque[${upper}_JOINTS]);

/* Computes the errors that the law itself asks for at the sample whose torque the next step computes, motor side [rad],
 * [rad/s]: reference - motor, where motors lead the arm. It gets what that step will get. A policy above the law takes
 * them from the errors that it sees at that sample. */
void ${name}_own_error(const ${name}_state *state, const double q[${upper}_WINDOW],
    const double motor_dq[${upper}_WINDOW], const double motor_ddq[${upper}_WINDOW],
    double position[${upper}_JOINTS], double speed[${upper}_JOINTS]);

/* Computes the same at the instant of that sample, as if torques did not run straight between samples. It differs where
 * friction acts on the arm. A policy whose ONNX file says law_error = instant_error takes it instead. */
void ${name}_instant_error(const ${name}_state *state, double position[${upper}_JOINTS], double speed[${upper}_JOINTS]);

#endif
