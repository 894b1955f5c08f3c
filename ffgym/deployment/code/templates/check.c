/* Runs the law along its motion, and compares every torque with the simulation's.
 *
 *     cc -std=c99 -O2 -ffp-contract=off ${name}.c check.c -lm -o check && ./check reference.csv
 *
 * Prints the largest differences, and the time of a step: the worst and the median sample, each the shortest of
 * $repetitions runs, so that the times of the law are told from interruptions by the operating system; and the longest
 * step of all. The exit code is 1 where a number differs by more than the tolerance.
 */
#define _POSIX_C_SOURCE 199309L /* clock_gettime */
#include "${name}.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define JOINTS ${upper}_JOINTS
#define SAMPLES ${upper}_SAMPLES
#define RUNS $repetitions

#define GIVEN 3
#define FOUND 5
#define PARTS (GIVEN + FOUND)

/* q, motor_dq, motor_ddq; of the simulation: torque, errors that the law asks for, position and speed, and the same at
 * the instant */
static double reference[PARTS][SAMPLES][JOINTS];
static const double tolerance[FOUND] = {$tolerances}; /* $share of the largest along the motion */
static double shortest[SAMPLES];

static double now_us(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e6 * (double)time.tv_sec + 1e-3 * (double)time.tv_nsec;
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static int read_reference(const char *path)
{
    FILE *file = fopen(path, "r");
    int letter, ok = file != NULL;
    if (ok)
        while ((letter = getc(file)) != '\n' && letter != EOF) {
        }
    for (long k = 0; ok && k < SAMPLES; ++k)
        for (int part = 0; ok && part < PARTS; ++part)
            for (int j = 0; ok && j < JOINTS; ++j)
                ok = fscanf(file, "%lf,", &reference[part][k][j]) == 1;
    if (file != NULL)
        fclose(file);
    return ok;
}

int main(int count, char **arguments)
{
    static ${name}_state state;
    double largest[FOUND] = {0.0}, longest = 0.0;
    if (count != 2 || !read_reference(arguments[1])) {
        fprintf(stderr, "usage: check reference.csv, with %d samples of %d joints\n", SAMPLES, JOINTS);
        return 2;
    }
    for (int run = 0; run < RUNS; ++run) {
        ${name}_start(&state);
        for (long k = 0; k < SAMPLES - 1; ++k) {
            double window[GIVEN][${upper}_WINDOW], found[FOUND][JOINTS], begun, taken;
            for (int part = 0; part < GIVEN; ++part)
                for (int i = 0; i <= ${upper}_PREVIEW; ++i)
                    for (int j = 0; j < JOINTS; ++j)
                        window[part][i * JOINTS + j] = reference[part][k + i < SAMPLES ? k + i : SAMPLES - 1][j];
            ${name}_own_error(&state, window[0], window[1], window[2], found[1], found[2]);
            ${name}_instant_error(&state, found[3], found[4]);
            begun = now_us();
            if (${name}_step(&state, window[0], window[1], window[2], found[0]) != 0)
                return 2;
            taken = now_us() - begun;
            if (run == 0 || taken < shortest[k])
                shortest[k] = taken;
            if (taken > longest)
                longest = taken;
            for (int part = 0; part < FOUND; ++part)
                for (int j = 0; j < JOINTS; ++j) {
                    const double off = fabs(found[part][j] - reference[GIVEN + part][k + 1][j]);
                    if (!isnan(largest[part]) && !(off <= largest[part]))
                        largest[part] = off; /* which keeps one that is no number */
                }
        }
    }
    qsort(shortest, SAMPLES - 1, sizeof shortest[0], compare);
    printf("difference_torque_Nm %.17g\n", largest[0]);
    printf("difference_own_position_rad %.17g\ndifference_own_speed_rad_s %.17g\n", largest[1], largest[2]);
    printf("worst_us %.4g\nmedian_us %.4g\nlongest_us %.4g\n", shortest[SAMPLES - 2], shortest[(SAMPLES - 1) / 2], longest);
    for (int part = 0; part < FOUND; ++part)
        if (!(largest[part] <= tolerance[part]))
            return 1;
    return 0;
}
