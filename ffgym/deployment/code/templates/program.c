/* A program with its feed-forward law: set-points of the next control step, as the plant takes them.
 *
 * Outputs at an instant are those that are to be reached a control step later: position [rad] and velocity [rad/s] of
 * each motor, all feed-forward torque [N m], and the part of it that the law adds [N m]. */
#include "${name}.h"
#include "fmu.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define N ${upper}_JOINTS
#define SAMPLES ${upper}_SAMPLES

/* q, motor_q, motor_dq, motor_ddq, and torque of the controller, at each sample */
static const double reference[5][SAMPLES][N] = {
$reference};

typedef struct {
    ${name}_state law;
    long sample;
    double added[N]; /* torque that the law adds at the sample */
} program;

int fmu_open(fmu_model *fmu, const char *resources)
{
    (void)resources;
    fmu->own = calloc(1, sizeof(program));
    return fmu->own == NULL;
}

static void copy_window(double window[${upper}_WINDOW], int part, long sample)
{
    for (int i = 0; i <= ${upper}_PREVIEW; ++i) {
        const long k = sample + i < SAMPLES ? sample + i : SAMPLES - 1;
        memcpy(window + i * N, reference[part][k], N * sizeof(double));
    }
}

/* Advances to the next sample, and writes it to the outputs; the last one holds. */
static void advance(fmu_model *fmu)
{
    program *own = fmu->own;
    double q[${upper}_WINDOW], dq[${upper}_WINDOW], ddq[${upper}_WINDOW], *out = fmu->values + fmu_inputs;
    if (own->sample < SAMPLES - 1) {
        copy_window(q, 0, own->sample);
        copy_window(dq, 2, own->sample);
        copy_window(ddq, 3, own->sample);
        ${name}_step(&own->law, q, dq, ddq, own->added);
        ++own->sample;
    }
    for (int j = 0; j < N; ++j) {
        out[j] = reference[1][own->sample][j];
        out[N + j] = reference[2][own->sample][j];
        out[2 * N + j] = reference[4][own->sample][j] + own->added[j];
        out[3 * N + j] = own->added[j];
    }
}

int fmu_begin(fmu_model *fmu)
{
    program *own = fmu->own;
    ${name}_start(&own->law);
    own->sample = 0;
    memset(own->added, 0, sizeof own->added);
    advance(fmu);
    return 0;
}

int fmu_step(fmu_model *fmu, double step)
{
    const long count = lround(step / ${upper}_DT);
    if (count < 1 || fabs(step - (double)count * ${upper}_DT) > 1e-6 * ${upper}_DT) {
        snprintf(fmu->message, sizeof fmu->message, "a step of %g s is no multiple of the control step of %g s", step,
            ${upper}_DT);
        return 1;
    }
    for (long i = 0; i < count; ++i)
        advance(fmu);
    return 0;
}

void fmu_close(fmu_model *fmu)
{
    free(fmu->own);
}

void *fmu_copy(const fmu_model *fmu)
{
    program *copied = malloc(sizeof *copied);
    if (copied != NULL)
        memcpy(copied, fmu->own, sizeof *copied);
    return copied;
}

void fmu_restore(fmu_model *fmu, const void *copied) { memcpy(fmu->own, copied, sizeof(program)); }
void fmu_discard(void *copied) { free(copied); }
