/* Instances of an FMU: memory, values by reference, time. */
#include "fmu.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

fmu_model *fmu_new(const char *token, const char *resources)
{
    fmu_model *model;
    if (token == NULL || strcmp(token, fmu_token) != 0)
        return NULL;
    model = calloc(1, sizeof *model);
    if (model == NULL)
        return NULL;
    model->values = calloc(fmu_inputs + fmu_outputs + 1, sizeof(double));
    if (model->values == NULL || fmu_open(model, resources) != 0 || fmu_reset(model) != 0) {
        fmu_free(model);
        return NULL;
    }
    return model;
}

int fmu_reset(fmu_model *model)
{
    memcpy(model->values, fmu_start_values, (fmu_inputs + fmu_outputs) * sizeof(double));
    model->time = 0.0;
    return fmu_begin(model);
}

void fmu_free(fmu_model *model)
{
    if (model == NULL)
        return;
    fmu_close(model);
    free(model->values);
    free(model);
}

int fmu_get(fmu_model *model, const unsigned references[], size_t n, double values[])
{
    model->values[fmu_inputs + fmu_outputs] = model->time;
    for (size_t k = 0; k < n; ++k) {
        if (references[k] > fmu_inputs + fmu_outputs) {
            snprintf(model->message, sizeof model->message, "there is no variable %u", references[k]);
            return 1;
        }
        values[k] = model->values[references[k]];
    }
    return 0;
}

int fmu_set(fmu_model *model, const unsigned references[], size_t n, const double values[])
{
    for (size_t k = 0; k < n; ++k) {
        if (references[k] >= fmu_inputs) {
            snprintf(model->message, sizeof model->message, "variable %u is no input", references[k]);
            return 1;
        }
        model->values[references[k]] = values[k];
    }
    return 0;
}

int fmu_advance(fmu_model *model, double step)
{
    if (fmu_step(model, step) != 0)
        return 1;
    model->time += step;
    return 0;
}

typedef struct {
    double time, *values;
    void *own;
} saved;

void fmu_drop(void **state)
{
    saved *one = *state;
    if (one != NULL) {
        if (one->own != NULL)
            fmu_discard(one->own);
        free(one->values);
        free(one);
    }
    *state = NULL;
}

int fmu_save(fmu_model *model, void **state)
{
    const size_t size = (fmu_inputs + fmu_outputs) * sizeof(double);
    saved *one = calloc(1, sizeof *one);
    fmu_drop(state);
    *state = one;
    snprintf(model->message, sizeof model->message, "there is no memory for a state");
    if (one == NULL)
        return 1;
    one->time = model->time;
    one->values = malloc(size);
    one->own = fmu_copy(model);
    if (one->values == NULL || one->own == NULL) {
        fmu_drop(state);
        return 1;
    }
    memcpy(one->values, model->values, size);
    return 0;
}

int fmu_load(fmu_model *model, const void *state)
{
    const saved *one = state;
    if (one == NULL) {
        snprintf(model->message, sizeof model->message, "there is no state to set");
        return 1;
    }
    model->time = one->time;
    memcpy(model->values, one->values, (fmu_inputs + fmu_outputs) * sizeof(double));
    fmu_restore(model, one->own);
    return 0;
}
