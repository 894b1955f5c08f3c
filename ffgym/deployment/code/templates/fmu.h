/* What an FMU of ffgym is made of: a model (plant.c or program.c) behind a face (fmi2.c or fmi3.c). */
#ifndef FMU_H
#define FMU_H

#include <stddef.h>

typedef struct {
    double *values; /* by value reference: inputs first, then outputs, then the time */
    double time;    /* [s] on the clock of the importer */
    void *own;      /* what the model keeps */
    char message[256];
} fmu_model;

/* Constants of the model, in fmu_data.c. */
extern const char fmu_token[];
extern const size_t fmu_inputs, fmu_outputs;
extern const double fmu_start_values[];

/* Functions of the model; they return 0, or 1 with a message. `resources` is the folder of that name. */
int fmu_open(fmu_model *model, const char *resources);
int fmu_begin(fmu_model *model); /* at the end of the initialization: outputs at the start */
int fmu_step(fmu_model *model, double step);
void fmu_close(fmu_model *model);
void *fmu_copy(const fmu_model *model);                 /* what the model keeps, copied; NULL without memory */
void fmu_restore(fmu_model *model, const void *copied); /* back to a copy */
void fmu_discard(void *copied);

/* What both faces share, in fmu.c. */
fmu_model *fmu_new(const char *token, const char *resources);
int fmu_reset(fmu_model *model);
void fmu_free(fmu_model *model);
int fmu_get(fmu_model *model, const unsigned references[], size_t n, double values[]);
int fmu_set(fmu_model *model, const unsigned references[], size_t n, const double values[]);
int fmu_advance(fmu_model *model, double step);
int fmu_save(fmu_model *model, void **state); /* `*state` is made where it is NULL */
int fmu_load(fmu_model *model, const void *state);
void fmu_drop(void **state);

#endif
