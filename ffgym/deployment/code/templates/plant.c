/* The robot under its servos, as MuJoCo simulates it; model.mjb in the resources.
 *
 * Inputs are set-points for the end of the next step: position [rad], velocity [rad/s] and torque [N m] of each motor.
 * Within a step they run from the last ones, as a drive interpolates them: positions and velocities by a cubic, torques
 * straight. A step is any multiple of the physics step. */
#include "fmu.h"

#include <math.h>
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define N $joints

static const char *const joints[N] = {$names};

typedef struct {
    mjModel *model;
    mjData *data;
    double last[3 * N]; /* set-points at the end of the last step: positions, velocities, torques */
    int servo[N], motor[N], bend[N], tcp;
} plant;

static int named(const mjModel *model, int type, const char *joint, const char *ending)
{
    char name[256];
    snprintf(name, sizeof name, "%s%s", joint, ending);
    return mj_name2id(model, type, name);
}

int fmu_open(fmu_model *fmu, const char *resources)
{
    char path[4096];
    plant *own = calloc(1, sizeof *own);
    fmu->own = own;
    if (own == NULL || mj_version() != mjVERSION_HEADER)
        return 1;
    snprintf(path, sizeof path, "%s/model.mjb", resources);
    own->model = mj_loadModel(path, NULL);
    if (own->model == NULL)
        return 1;
    own->data = mj_makeData(own->model);
    own->tcp = mj_name2id(own->model, mjOBJ_SITE, "tcp");
    for (int j = 0; j < N; ++j) {
        own->servo[j] = named(own->model, mjOBJ_ACTUATOR, joints[j], "_servo");
        own->motor[j] = named(own->model, mjOBJ_JOINT, joints[j], "_motor");
        own->bend[j] = named(own->model, mjOBJ_JOINT, joints[j], "_deflection");
        if (own->servo[j] < 0 || own->motor[j] < 0)
            return 1;
    }
    return own->data == NULL;
}

static void write_outputs(fmu_model *fmu)
{
    const plant *own = fmu->own;
    double *out = fmu->values + fmu_inputs;
    mj_forward(own->model, own->data);
    for (int j = 0; j < N; ++j) {
        const int motor = own->motor[j], bend = own->bend[j];
        out[j] = own->data->actuator_length[own->servo[j]];
        out[N + j] = own->data->actuator_velocity[own->servo[j]];
        out[2 * N + j] = own->data->qpos[own->model->jnt_qposadr[motor]];
        out[3 * N + j] = own->data->qvel[own->model->jnt_dofadr[motor]];
        if (bend >= 0) {
            out[2 * N + j] += own->data->qpos[own->model->jnt_qposadr[bend]];
            out[3 * N + j] += own->data->qvel[own->model->jnt_dofadr[bend]];
        }
    }
    if (own->tcp >= 0)
        memcpy(out + 4 * N, own->data->site_xpos + 3 * own->tcp, 3 * sizeof(double));
}

int fmu_begin(fmu_model *fmu)
{
    plant *own = fmu->own;
    mj_resetDataKeyframe(own->model, own->data, mj_name2id(own->model, mjOBJ_KEY, "start"));
    memcpy(own->last, fmu_start_values, sizeof own->last); /* inputs are for the end of the first step already */
    write_outputs(fmu);
    return 0;
}

/* MuJoCo warns of states and set-points that are no numbers, or beyond all bounds, and goes on from others. */
static int check_stable(fmu_model *fmu)
{
    const mjWarningStat *warning = ((plant *)fmu->own)->data->warning;
    static const int signs[] = {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC, mjWARN_BADCTRL};
    int count = 0;
    for (size_t k = 0; k < sizeof signs / sizeof signs[0]; ++k)
        count += warning[signs[k]].number;
    if (count == 0)
        return 0;
    snprintf(fmu->message, sizeof fmu->message, "the simulation became unstable, or a set-point is no number; reset it");
    return 1;
}

int fmu_step(fmu_model *fmu, double step)
{
    plant *own = fmu->own;
    const double dt = own->model->opt.timestep, *const next = fmu->values;
    const long count = lround(step / dt);
    if (count < 1 || fabs(step - (double)count * dt) > 1e-6 * dt) {
        snprintf(fmu->message, sizeof fmu->message, "a step of %g s is no multiple of the physics step of %g s", step, dt);
        return 1;
    }
    for (long i = 0; i < count; ++i) {
        const double x = (double)i / (double)count;
        for (int j = 0; j < N; ++j) {
            const double p = own->last[j], v = own->last[N + j], u = own->last[2 * N + j], rise = next[j] - p;
            const double square = 3 * rise - step * (2 * v + next[N + j]);
            const double cube = step * (v + next[N + j]) - 2 * rise;
            double *control = own->data->ctrl + 3 * j;
            control[0] = ((cube * x + square) * x + step * v) * x + p;
            control[1] = (3 / step * cube * x + 2 / step * square) * x + v;
            control[2] = (next[2 * N + j] - u) * x + u;
        }
        mj_step(own->model, own->data);
    }
    memcpy(own->last, next, sizeof own->last);
    write_outputs(fmu);
    return check_stable(fmu);
}

void fmu_close(fmu_model *fmu)
{
    plant *own = fmu->own;
    if (own != NULL) {
        mj_deleteData(own->data);
        mj_deleteModel(own->model);
        free(own);
    }
}

typedef struct {
    mjData *data;
    double last[3 * N];
} kept;

void *fmu_copy(const fmu_model *fmu)
{
    const plant *own = fmu->own;
    kept *copied = calloc(1, sizeof *copied);
    if (copied == NULL)
        return NULL;
    copied->data = mj_copyData(NULL, own->model, own->data);
    if (copied->data == NULL) {
        free(copied);
        return NULL;
    }
    memcpy(copied->last, own->last, sizeof own->last);
    return copied;
}

void fmu_restore(fmu_model *fmu, const void *copied)
{
    const kept *from = copied;
    plant *own = fmu->own;
    mj_copyData(own->data, own->model, from->data);
    memcpy(own->last, from->last, sizeof own->last);
}

void fmu_discard(void *copied)
{
    mj_deleteData(((kept *)copied)->data);
    free(copied);
}
