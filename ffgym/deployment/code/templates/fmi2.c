/* Face of FMI 2.0 for co-simulation. */
#include "fmi2Functions.h"
#include "fmu.h"

#include <stdlib.h>
#include <string.h>

typedef struct {
    fmu_model *model;
    const fmi2CallbackFunctions *functions;
    char name[128];
} instance;

static fmi2Status told(instance *one, int failed)
{
    if (failed && one->functions != NULL && one->functions->logger != NULL)
        one->functions->logger(one->functions->componentEnvironment, one->name, fmi2Error, "logStatusError", "%s",
            one->model->message);
    return failed ? fmi2Error : fmi2OK;
}

/* Path of a file URI: without file://, and with %xx as bytes. */
static void path_of(const char *uri, char path[], size_t size)
{
    size_t k = 0;
    if (uri == NULL)
        uri = "";
    if (strncmp(uri, "file://", 7) == 0)
        uri += 7;
    else if (strncmp(uri, "file:", 5) == 0)
        uri += 5;
    for (; *uri != '\0' && k + 1 < size; ++uri) {
        char digits[3] = {0};
        if (*uri == '%' && uri[1] != '\0' && uri[2] != '\0') {
            memcpy(digits, uri + 1, 2);
            path[k++] = (char)strtol(digits, NULL, 16);
            uri += 2;
        } else
            path[k++] = *uri;
    }
    path[k] = '\0';
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
    const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    char path[4096];
    instance *one = type == fmi2CoSimulation ? calloc(1, sizeof *one) : NULL;
    (void)visible;
    (void)logging;
    if (one == NULL)
        return NULL;
    one->functions = functions;
    strncpy(one->name, name == NULL ? "" : name, sizeof one->name - 1);
    path_of(resources, path, sizeof path);
    one->model = fmu_new(token, path);
    if (one->model == NULL) {
        free(one);
        return NULL;
    }
    return one;
}

void fmi2FreeInstance(fmi2Component c)
{
    if (c != NULL) {
        fmu_free(((instance *)c)->model);
        free(c);
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start,
    fmi2Boolean stop_defined, fmi2Real stop)
{
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop;
    ((instance *)c)->model->time = start;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return told(c, fmu_begin(((instance *)c)->model)); }
fmi2Status fmi2Reset(fmi2Component c) { return told(c, fmu_reset(((instance *)c)->model)); }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real values[])
{
    return told(c, fmu_get(((instance *)c)->model, vr, n, values));
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real values[])
{
    return told(c, fmu_set(((instance *)c)->model, vr, n, values));
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_going_back)
{
    (void)no_going_back;
    ((instance *)c)->model->time = time;
    return told(c, fmu_advance(((instance *)c)->model, step));
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    *value = ((instance *)c)->model->time;
    return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) { return told(c, fmu_save(((instance *)c)->model, state)); }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) { return told(c, fmu_load(((instance *)c)->model, state)); }

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    if (state != NULL)
        fmu_drop(state);
    return fmi2OK;
}
