/* Face of FMI 3.0 for co-simulation. */
#include "fmi3Functions.h"
#include "fmu.h"

#include <stdlib.h>

typedef struct {
    fmu_model *model;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} instance;

static fmi3Status told(instance *one, int failed)
{
    if (failed && one->log != NULL)
        one->log(one->environment, fmi3Error, "logStatusError", one->model->message);
    return failed ? fmi3Error : fmi3OK;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n_required,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    instance *one = calloc(1, sizeof *one);
    (void)name, (void)visible, (void)logging, (void)events, (void)early, (void)required, (void)n_required, (void)update;
    if (one == NULL)
        return NULL;
    one->environment = environment;
    one->log = log;
    one->model = fmu_new(token, resources);
    if (one->model == NULL) {
        free(one);
        return NULL;
    }
    return one;
}

void fmi3FreeInstance(fmi3Instance c)
{
    if (c != NULL) {
        fmu_free(((instance *)c)->model);
        free(c);
    }
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
    fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop)
{
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
    ((instance *)c)->model->time = start;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return told(c, fmu_begin(((instance *)c)->model)); }
fmi3Status fmi3Reset(fmi3Instance c) { return told(c, fmu_reset(((instance *)c)->model)); }

fmi3Status fmi3GetFloat64(
    fmi3Instance c, const fmi3ValueReference references[], size_t n, fmi3Float64 values[], size_t n_values)
{
    return n != n_values ? fmi3Error : told(c, fmu_get(((instance *)c)->model, references, n, values));
}

fmi3Status fmi3SetFloat64(
    fmi3Instance c, const fmi3ValueReference references[], size_t n, const fmi3Float64 values[], size_t n_values)
{
    return n != n_values ? fmi3Error : told(c, fmu_set(((instance *)c)->model, references, n, values));
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_going_back,
    fmi3Boolean *needs_events, fmi3Boolean *ends, fmi3Boolean *early, fmi3Float64 *last_time)
{
    int failed;
    (void)no_going_back;
    ((instance *)c)->model->time = time;
    failed = fmu_advance(((instance *)c)->model, step);
    *needs_events = *ends = *early = 0;
    *last_time = failed ? time : time + step;
    return told(c, failed);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) { return told(c, fmu_save(((instance *)c)->model, state)); }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) { return told(c, fmu_load(((instance *)c)->model, state)); }

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    (void)c;
    if (state != NULL)
        fmu_drop(state);
    return fmi3OK;
}
