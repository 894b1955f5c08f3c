/* Runs the law along its motion, and compares every torque with the simulation's.
 *
 *     cc -std=c99 -O2 -ffp-contract=off ${name}.c check.c -lm -o check && ./check reference.csv
 *
 * Prints the largest difference [N m], and the time of a step: the worst and the median sample, each the shortest of
 * $repetitions runs, so that the times of the law are told from interruptions by the operating system; and the longest
 * step of all. The exit code is 1 where a torque differs by more than TOLERANCE.
 */
#define _POSIX_C_SOURCE 199309L /* clock_gettime */
#include "${name}.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define JOINTS ${upper}_JOINTS
#define SAMPLES ${upper}_SAMPLES
#define TOLERANCE $tolerance
#define RUNS $repetitions

static double reference[4][SAMPLES][JOINTS]; /* q, motor_dq, motor_ddq, torque of the simulation */
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
        for (int part = 0; ok && part < 4; ++part)
            for (int j = 0; ok && j < JOINTS; ++j)
                ok = fscanf(file, "%lf,", &reference[part][k][j]) == 1;
    if (file != NULL)
        fclose(file);
    return ok;
}

int main(int count, char **arguments)
{
    static ${name}_state state;
    double largest = 0.0, longest = 0.0;
    if (count != 2 || !read_reference(arguments[1])) {
        fprintf(stderr, "usage: check reference.csv, with %d samples of %d joints\n", SAMPLES, JOINTS);
        return 2;
    }
    for (int run = 0; run < RUNS; ++run) {
        ${name}_start(&state);
        for (long k = 0; k < SAMPLES - 1; ++k) {
            double window[3][${upper}_WINDOW], torque[JOINTS], begun, taken;
            for (int part = 0; part < 3; ++part)
                for (int i = 0; i <= ${upper}_PREVIEW; ++i)
                    for (int j = 0; j < JOINTS; ++j)
                        window[part][i * JOINTS + j] = reference[part][k + i < SAMPLES ? k + i : SAMPLES - 1][j];
            begun = now_us();
            if (${name}_step(&state, window[0], window[1], window[2], torque) != 0)
                return 2;
            taken = now_us() - begun;
            if (run == 0 || taken < shortest[k])
                shortest[k] = taken;
            if (taken > longest)
                longest = taken;
            for (int j = 0; j < JOINTS; ++j) {
                const double off = fabs(torque[j] - reference[3][k + 1][j]);
                largest = off <= largest ? largest : off; /* keeps a difference that is no number */
            }
        }
    }
    qsort(shortest, SAMPLES - 1, sizeof shortest[0], compare);
    printf("largest_difference_Nm %.17g\n", largest);
    printf("worst_us %.4g\nmedian_us %.4g\nlongest_us %.4g\n", shortest[SAMPLES - 2], shortest[(SAMPLES - 1) / 2], longest);
    return largest <= TOLERANCE ? 0 : 1;
}
