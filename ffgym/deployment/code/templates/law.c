/* $title: see ${name}.h. Statements of a step are those of the law in ffgym, in their order; do not let the compiler
 * change them (no -ffast-math; -ffp-contract=off gives the bits of processors without fused multiply-add). */
#include "${name}.h"

#include <math.h>
#include <string.h>

static const double start[${upper}_MEMORY] = {$start};
$terms
void ${name}_start(${name}_state *state)
{
    memcpy(state->memory, start, sizeof start);
    state->step = 0;
}

int ${name}_step(${name}_state *state, const double q[${upper}_WINDOW], const double motor_dq[${upper}_WINDOW],
    const double motor_ddq[${upper}_WINDOW], double torque[${upper}_JOINTS])
{
    const double *const memory = state->memory;
    double next[${upper}_MEMORY] = {0.0};
$tables
$program
    (void)q;
    (void)motor_dq;
    (void)motor_ddq;
    (void)memory;
$statements
    memcpy(state->memory, next, sizeof next);
    ++state->step;
    return 0;
}

void ${name}_own_error(const ${name}_state *state, const double q[${upper}_WINDOW],
    const double motor_dq[${upper}_WINDOW], const double motor_ddq[${upper}_WINDOW],
    double position[${upper}_JOINTS], double speed[${upper}_JOINTS])
{
    const double *const memory = state->memory;
$own_tables
    (void)q;
    (void)motor_dq;
    (void)motor_ddq;
    (void)memory;
$own_statements
}

void ${name}_instant_error(const ${name}_state *state, double position[${upper}_JOINTS], double speed[${upper}_JOINTS])
{
    const double *const memory = state->memory;
$instant_tables
    (void)memory;
$instant_statements
}
