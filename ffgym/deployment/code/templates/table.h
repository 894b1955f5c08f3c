/* Reader of table.bin, which ffgym writes: C99, no allocation, no files.
 *
 * Give it the bytes of the file, wherever they lie (flash, memory, a buffer that the caller reads the file into):
 *
 *     table law;
 *     if (table_open(&law, bytes, size) != 0) ...             not such a table
 *     const int torque = table_find(&law, "torque [N m]");     -1 if there is none
 *     const double u = table_at(&law, torque, k, j);           sample k = time / law.dt, joint j; both from 0
 *
 * A sample belongs to the instant k * dt; join samples of torque by straight lines. Beyond the end the last one holds.
 */
#ifndef TABLE_H
#define TABLE_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct {
    const unsigned char *names, *values;
    uint32_t joints, quantities, samples;
    double dt; /* time between samples [s] */
} table;

/* Opens a table in `size` bytes. Returns 0; or 1 where they are no table, cut off, or of the other order of bytes. */
static inline int table_open(table *t, const unsigned char *bytes, size_t size)
{
    uint32_t head[4];
    if (size < 32 || memcmp(bytes, "FFGYMTB1", 8) != 0)
        return 1;
    memcpy(head, bytes + 8, sizeof head);
    memcpy(&t->dt, bytes + 24, sizeof t->dt);
    t->joints = head[1];
    t->quantities = head[2];
    t->samples = head[3];
    if (head[0] != 1 || t->joints == 0 || t->quantities == 0 || t->samples == 0)
        return 1;
    /* the rest must hold all names and numbers; told by division, as products of a wrong head may overflow */
    size -= 32;
    if (t->quantities > size / 32)
        return 1;
    size -= (size_t)32 * t->quantities;
    t->names = bytes + 32;
    t->values = t->names + (size_t)32 * t->quantities;
    return size % 8 != 0 || size / 8 % t->joints != 0 || size / 8 / t->joints % t->quantities != 0
        || size / 8 / t->joints / t->quantities != t->samples;
}

/* Finds a quantity by its name with unit; -1 if there is none. */
static inline int table_find(const table *t, const char *name)
{
    for (uint32_t k = 0; k < t->quantities; ++k)
        if (strncmp((const char *)t->names + 32 * k, name, 32) == 0)
            return (int)k;
    return -1;
}

/* Number of a quantity at a sample, for a joint; 0 where there is no such quantity or joint. */
static inline double table_at(const table *t, int quantity, uint32_t sample, uint32_t joint)
{
    double value = 0.0;
    if (quantity >= 0 && (uint32_t)quantity < t->quantities && joint < t->joints) {
        const uint32_t k = sample < t->samples ? sample : t->samples - 1;
        const size_t place = ((size_t)k * t->quantities + (size_t)quantity) * t->joints + joint;
        memcpy(&value, t->values + 8 * place, sizeof value);
    }
    return value;
}

#endif
