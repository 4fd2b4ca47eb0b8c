/* The kernel for Python: numbers come and go as contiguous buffers of doubles, and the loops are
   those of the best instruction set that the processor has. */

#define Py_LIMITED_API 0x030b0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <stdint.h>
#include <string.h>

#include "loops.h"
#include "steering.h"

#ifdef __x86_64__
extern const struct loops loops_v4, loops_v3, loops_v1;
static const struct loops *const LEVELS[] = {&loops_v4, &loops_v3, &loops_v1};

static int has(const struct loops *level)
{
    __builtin_cpu_init();
    if (level == &loops_v4)
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw")
               && __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq")
               && __builtin_cpu_supports("avx512vl");
    if (level == &loops_v3)
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")
               && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    return 1;
}
#else
extern const struct loops loops_base;
static const struct loops *const LEVELS[] = {&loops_base};

static int has(const struct loops *level)
{
    (void)level;
    return 1;
}
#endif

enum { COUNT = sizeof LEVELS / sizeof *LEVELS };
static const struct loops *chosen;

/* Buffers of doubles; those from `written` on can be written to. */
struct numbers {
    Py_buffer view[8];
    int count;
};

static void give_back(struct numbers *of)
{
    while (of->count > 0)
        PyBuffer_Release(&of->view[--of->count]);
}

static int take(struct numbers *of, PyObject *const *from, int count, int written)
{
    of->count = 0;
    for (int n = 0; n < count; n++)
    {
        int flags = PyBUF_FORMAT | PyBUF_C_CONTIGUOUS | (n < written ? 0 : PyBUF_WRITABLE);
        if (PyObject_GetBuffer(from[n], &of->view[n], flags) < 0)
        {
            give_back(of);
            return 0;
        }
        of->count++;
        if (!of->view[n].format || of->view[n].format[0] != 'd' || of->view[n].format[1])
        {
            give_back(of);
            PyErr_SetString(PyExc_TypeError, "expected arrays of float64");
            return 0;
        }
        if ((uintptr_t)of->view[n].buf % _Alignof(double))
        {
            give_back(of);
            PyErr_SetString(PyExc_TypeError, "expected aligned arrays");
            return 0;
        }
    }
    return 1;
}

static size_t size(const struct numbers *of, int n)
{
    return (size_t)of->view[n].len / sizeof(double);
}

/* Whether an array has a times b numbers, which need not fit into any. */
static int is_product(const struct numbers *of, int n, size_t a, size_t b)
{
    size_t all;
    return !__builtin_mul_overflow(a, b, &all) && size(of, n) == all;
}

static double *values(const struct numbers *of, int n)
{
    return of->view[n].buf;
}

static PyObject *wrong(struct numbers *of)
{
    give_back(of);
    if (!PyErr_Occurred())
        PyErr_SetString(PyExc_ValueError, "arrays of other sizes than one another's");
    return NULL;
}

static PyObject *answer(struct numbers *of, size_t count)
{
    give_back(of);
    return PyLong_FromSize_t(count);
}

/* Whether the form is the exact one, its parameters, two angles and the place of two offsets. */
static int take_form(PyObject *args, int *exact, struct numbers *of)
{
    PyObject *given[5];
    return PyArg_ParseTuple(args, "pOOOOO", exact, given, given + 1, given + 2, given + 3, given + 4)
           && take(of, given, 5, 3);
}

static PyObject *scattered(PyObject *self, PyObject *args)
{
    int exact;
    struct numbers of;
    (void)self;
    if (!take_form(args, &exact, &of))
        return NULL;
    size_t n = size(&of, 1), large;
    if (size(&of, 0) != PARAMETERS || size(&of, 2) != n || size(&of, 3) != n || size(&of, 4) != n)
        return wrong(&of);
    Py_BEGIN_ALLOW_THREADS
    large = chosen->scattered(exact, values(&of, 0), n, values(&of, 1), values(&of, 2),
                              values(&of, 3), values(&of, 4));
    Py_END_ALLOW_THREADS
    return answer(&of, large);
}

static PyObject *grid(PyObject *self, PyObject *args)
{
    int exact;
    struct numbers of;
    (void)self;
    if (!take_form(args, &exact, &of))
        return NULL;
    size_t columns = size(&of, 1), rows = size(&of, 2), large;
    if (size(&of, 0) != PARAMETERS || !is_product(&of, 3, columns, rows)
        || !is_product(&of, 4, columns, rows))
        return wrong(&of);
    double *room = PyMem_Calloc(columns + 1, COLUMN_ROOMS * sizeof(double));
    if (!room)
    {
        PyErr_NoMemory();
        return wrong(&of);
    }
    Py_BEGIN_ALLOW_THREADS
    large = chosen->grid(exact, values(&of, 0), columns, values(&of, 1), rows, values(&of, 2), room,
                         values(&of, 3), values(&of, 4));
    Py_END_ALLOW_THREADS
    PyMem_Free(room);
    return answer(&of, large);
}

static PyObject *look_up(PyObject *self, PyObject *args)
{
    PyObject *given[7];
    struct numbers of;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOOO", given, given + 1, given + 2, given + 3, given + 4,
                          given + 5, given + 6)
        || !take(&of, given, 7, 5))
        return NULL;
    size_t rows = size(&of, 0), row = size(&of, 1), n = size(&of, 3), beyond;
    if (rows < 2 || row < 2 || rows > INT32_MAX / row || !is_product(&of, 2, rows, 2 * row)
        || size(&of, 4) != n || size(&of, 5) != n || size(&of, 6) != n)
        return wrong(&of);
    struct table t = {values(&of, 2), (ptrdiff_t)rows, (ptrdiff_t)row,
                      values(&of, 0)[0], values(&of, 0)[rows - 1],
                      values(&of, 1)[0], values(&of, 1)[row - 1]};
    /* a table without extent, or of one that no number holds, has no places in it */
    double az_reach = t.last_az - t.first_az, zd_reach = t.last_zd - t.first_zd;
    if (!(az_reach > 0 && isfinite((double)rows / az_reach) && isfinite(az_reach) && zd_reach > 0
          && isfinite((double)row / zd_reach) && isfinite(zd_reach)))
        return answer(&of, n);
    Py_BEGIN_ALLOW_THREADS
    beyond = chosen->look_up(&t, n, values(&of, 3), values(&of, 4), values(&of, 5), values(&of, 6));
    Py_END_ALLOW_THREADS
    return answer(&of, beyond);
}

static PyObject *gram(PyObject *self, PyObject *args)
{
    PyObject *given[5];
    struct numbers of;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOO", given, given + 1, given + 2, given + 3, given + 4)
        || !take(&of, given, 5, 3))
        return NULL;
    size_t n = size(&of, 1), k = size(&of, 4);
    if (!is_product(&of, 0, n, k) || size(&of, 2) != n || !is_product(&of, 3, k, k))
        return wrong(&of);
    Py_BEGIN_ALLOW_THREADS
    chosen->gram(k, n, values(&of, 0), values(&of, 1), values(&of, 2), values(&of, 3),
                 values(&of, 4));
    Py_END_ALLOW_THREADS
    return answer(&of, k);
}

static PyObject *median(PyObject *self, PyObject *given)
{
    struct numbers of;
    (void)self;
    if (!take(&of, &given, 1, 1))
        return NULL;
    size_t n = size(&of, 0);
    if (!n)
        return wrong(&of);
    double *room = PyMem_Malloc(n * sizeof(double)), found = 0;
    if (!room)
    {
        PyErr_NoMemory();
        return wrong(&of);
    }
    Py_BEGIN_ALLOW_THREADS
    found = chosen->median(n, values(&of, 0), room);
    Py_END_ALLOW_THREADS
    PyMem_Free(room);
    give_back(&of);
    return PyFloat_FromDouble(found);
}

/* n indices below m. */
static int take_indices(PyObject *from, Py_buffer *rows, size_t n, size_t m)
{
    if (PyObject_GetBuffer(from, rows, PyBUF_FORMAT | PyBUF_C_CONTIGUOUS) < 0)
        return 0;
    const char *format = rows->format ? rows->format : "";
    if (rows->itemsize == sizeof(int64_t) && (!strcmp(format, "l") || !strcmp(format, "q"))
        && (size_t)rows->len == n * sizeof(int64_t))
    {
        const int64_t *of = rows->buf;
        size_t good = 0;
        for (size_t i = 0; i < n; i++)
            good += of[i] >= 0 && (size_t)of[i] < m;
        if (good == n)
            return 1;
    }
    PyBuffer_Release(rows);
    PyErr_SetString(PyExc_ValueError, "indices of what there is not");
    return 0;
}

static PyObject *whiten(PyObject *self, PyObject *args)
{
    PyObject *indices, *given[7];
    Py_ssize_t width;
    Py_buffer rows;
    struct numbers of;
    (void)self;
    if (!PyArg_ParseTuple(args, "nOOOOOOOO", &width, &indices, given, given + 1, given + 2,
                          given + 3, given + 4, given + 5, given + 6)
        || !take(&of, given, 7, 5))
        return NULL;
    size_t n = size(&of, 0), terms = size(&of, 1), all = size(&of, 4), k = (size_t)width;
    if (size(&of, 2) != terms || size(&of, 3) != n || size(&of, 5) != n || size(&of, 6) != all
        || width < 0 || (k ? all % k : all) || terms > 1024)
        return wrong(&of);
    if (!take_indices(indices, &rows, n, k ? all / k : SIZE_MAX))
        return wrong(&of);
    double *room = PyMem_Malloc((DRIFT_ROOM(n, terms) + 1) * sizeof(double));
    int done = 0;
    if (room)
    {
        Py_BEGIN_ALLOW_THREADS
        done = chosen->whiten(n, rows.buf, terms, k, values(&of, 0), values(&of, 1),
                              values(&of, 2), values(&of, 3), values(&of, 4), room, values(&of, 5),
                              values(&of, 6));
        Py_END_ALLOW_THREADS
    }
    else
        PyErr_NoMemory();
    PyMem_Free(room);
    PyBuffer_Release(&rows);
    return room ? answer(&of, (size_t)done) : wrong(&of);
}

static PyObject *products(PyObject *self, PyObject *args)
{
    Py_ssize_t width;
    PyObject *indices[2], *given[8];
    Py_buffer starts, places;
    struct numbers of;
    (void)self;
    if (!PyArg_ParseTuple(args, "nOOOOOOOOOO", &width, indices, indices + 1, given, given + 1,
                          given + 2, given + 3, given + 4, given + 5, given + 6, given + 7)
        || !take(&of, given, 8, 6))
        return NULL;
    size_t n = size(&of, 0), terms = size(&of, 1), there = size(&of, 4), q = (size_t)width;
    size_t p = n ? size(&of, 5) / n : 0;
    if (width < 0 || width > INT32_MAX || terms > 1024 || size(&of, 2) != terms
        || size(&of, 3) != n || size(&of, 5) != n * p || size(&of, 6) != n
        || size(&of, 7) != (q + p) * (q + p))
        return wrong(&of);
    if (!take_indices(indices[0], &starts, n + 1, there + 1))
        return wrong(&of);
    const int64_t *start = starts.buf;
    size_t ordered = start[0] == 0 && (size_t)start[n] == there;
    for (size_t i = 0; i < n; i++)
        ordered += start[i] <= start[i + 1];
    if (ordered != n + 1 || !take_indices(indices[1], &places, there, q))
    {
        PyBuffer_Release(&starts);
        return wrong(&of);
    }
    double *room = PyMem_Malloc(PRODUCTS_ROOM(n, q, p, terms) * sizeof(double));
    int done = 0;
    if (room)
    {
        Py_BEGIN_ALLOW_THREADS
        done = chosen->products(n, q, p, terms, values(&of, 0), values(&of, 1), values(&of, 2),
                                values(&of, 3), start, places.buf, values(&of, 4), values(&of, 5),
                                room, values(&of, 6), values(&of, 7));
        Py_END_ALLOW_THREADS
    }
    else
        PyErr_NoMemory();
    PyMem_Free(room);
    PyBuffer_Release(&starts);
    PyBuffer_Release(&places);
    return room ? answer(&of, (size_t)done) : wrong(&of);
}

static PyObject *elementary(PyObject *self, PyObject *args)
{
    int which;
    PyObject *given[3];
    struct numbers of;
    (void)self;
    if (!PyArg_ParseTuple(args, "iOOO", &which, given, given + 1, given + 2)
        || !take(&of, given, 3, 2))
        return NULL;
    size_t n = size(&of, 2);
    if (size(&of, 0) != n || size(&of, 1) != n)
        return wrong(&of);
    Py_BEGIN_ALLOW_THREADS
    chosen->elementary(which, n, values(&of, 0), values(&of, 1), values(&of, 2));
    Py_END_ALLOW_THREADS
    return answer(&of, n);
}

static PyObject *table_offsets(PyObject *self, PyObject *args)
{
    PyObject *given[6];
    struct numbers of;
    (void)self;
    if (!PyArg_ParseTuple(args, "OOOOOO", given, given + 1, given + 2, given + 3, given + 4,
                          given + 5)
        || !take(&of, given, 6, 4))
        return NULL;
    size_t n = size(&of, 1), m = size(&of, 2), all = size(&of, 4);
    int paired = n == m && all == n;
    if (size(&of, 0) != 12 || size(&of, 3) != m || size(&of, 5) != all || !(paired || all == n * m))
        return wrong(&of);
    struct altitude *room = PyMem_Malloc(steering_room(paired ? 0 : m));
    if (!room)
    {
        PyErr_NoMemory();
        return wrong(&of);
    }
    Py_BEGIN_ALLOW_THREADS
    steering_offsets(values(&of, 0), n, values(&of, 1), m, values(&of, 2), values(&of, 3), paired,
                     room, values(&of, 4), values(&of, 5));
    Py_END_ALLOW_THREADS
    PyMem_Free(room);
    return answer(&of, all);
}

static PyObject *table_refraction(PyObject *self, PyObject *args)
{
    PyObject *given[2];
    struct numbers of;
    (void)self;
    if (!PyArg_ParseTuple(args, "OO", given, given + 1) || !take(&of, given, 2, 1))
        return NULL;
    size_t n = size(&of, 0);
    if (size(&of, 1) != n)
        return wrong(&of);
    steering_refraction(n, values(&of, 0), values(&of, 1));
    return answer(&of, n);
}

static PyObject *table_rows(PyObject *self, PyObject *args)
{
    PyObject *given[2], *text = NULL;
    const char *az, *zd;
    Py_ssize_t az_all, zd_all, az_width, zd_width, width;
    struct numbers of;
    (void)self;
    if (!PyArg_ParseTuple(args, "y#ny#nnOO", &az, &az_all, &az_width, &zd, &zd_all, &zd_width,
                          &width, given, given + 1)
        || !take(&of, given, 2, 2))
        return NULL;
    if (az_width < 1 || az_width > 99 || zd_width < 1 || zd_width > 99 || width < 12 || width > 99
        || az_all % az_width || zd_all % zd_width)
        return wrong(&of);
    size_t n = (size_t)(az_all / az_width), m = (size_t)(zd_all / zd_width), all = n * m;
    size_t row = (size_t)(az_width + zd_width + 2 * width + 1);
    if (size(&of, 0) != all || size(&of, 1) != all || all > PY_SSIZE_T_MAX / row)
        return wrong(&of);
    if (!(text = PyBytes_FromStringAndSize(NULL, (Py_ssize_t)(all * row))))
        return wrong(&of);
    if (!steering_rows(n, az, (size_t)az_width, m, zd, (size_t)zd_width, (size_t)width,
                       values(&of, 0), values(&of, 1), PyBytes_AsString(text)))
    {
        Py_DECREF(text);
        PyErr_SetString(PyExc_OverflowError, "an offset does not fit");
        return wrong(&of);
    }
    give_back(&of);
    return text;
}

static PyObject *levels(PyObject *self, PyObject *unused)
{
    PyObject *found = PyList_New(0);
    (void)self;
    (void)unused;
    for (int n = 0; found && n < COUNT; n++)
    {
        PyObject *name = has(LEVELS[n]) ? PyUnicode_FromString(LEVELS[n]->name) : NULL;
        if (name && PyList_Append(found, name) < 0)
            Py_CLEAR(found);
        Py_XDECREF(name);
    }
    return found;
}

static PyObject *level(PyObject *self, PyObject *unused)
{
    (void)self;
    (void)unused;
    return PyUnicode_FromString(chosen->name);
}

static PyObject *choose(PyObject *self, PyObject *args)
{
    const char *name;
    (void)self;
    if (!PyArg_ParseTuple(args, "s", &name))
        return NULL;
    for (int n = 0; n < COUNT; n++)
        if (has(LEVELS[n]) && !strcmp(LEVELS[n]->name, name))
        {
            chosen = LEVELS[n];
            Py_RETURN_NONE;
        }
    PyErr_Format(PyExc_ValueError, "this processor has no %s", name);
    return NULL;
}

static PyMethodDef methods[] = {
    {"scattered", scattered, METH_VARARGS,
     "Write offsets at n points; return how many angles are too large for it.\n\n"
     "(exact, p, az, alt, d_az, d_alt), arrays of n float64, p the parameters of loops.h."},
    {"grid", grid, METH_VARARGS,
     "Write offsets at (altitudes, azimuths); return how many angles are too large for it.\n\n"
     "(exact, p, az, alt, d_az, d_alt), offsets of altitudes times azimuths."},
    {"look_up", look_up, METH_VARARGS,
     "Write offsets between a table's nodes; return how many places lie beyond it.\n\n"
     "(az nodes, zd nodes, both offsets at each node side by side, az, zd, d_az, d_zd)."},
    {"gram", gram, METH_VARARGS,
     "Write the products of k columns of n rows, each row so heavy, and those with a target.\n\n"
     "(columns of shape (k, n), weights, target, products of shape (k, k), products with it)."},
    {"median", median, METH_O, "Return the median of n finite numbers, one at least."},
    {"whiten", whiten, METH_VARARGS,
     "Write columns of unit scatter under drifts; return whether the variances allowed it.\n\n"
     "(k, indices of n rows, time, rates, variances of the drifts, variance of each row, columns\n"
     "(m, k), variance of each row given those before, whitened columns (m, k))."},
    {"products", products, METH_VARARGS,
     "Write the products of columns under scatter and a drift; return whether it allowed it.\n\n"
     "(q, rate, variance of the drift, starts of n rows among the numbers of q columns that are not\n"
     "zero, and the end, columns of the numbers, time, variance of each row, numbers, p columns that\n"
     "are full (n, p), variance of each row given those before, products (q + p, q + p))."},
    {"elementary", elementary, METH_VARARGS,
     "Write a function's values, for the tests: (0 sine, 1 cosine, 2 arcsine of x, 3 arctangent\n"
     "of y and x; y, x, values)."},
    {"table_offsets", table_offsets, METH_VARARGS,
     "Write the offsets of the RT32's table as its program computed them [deg].\n\n"
     "(p, az, zd, refraction at zd, d_az, d_zd): of a grid, or of as many pairs."},
    {"table_refraction", table_refraction, METH_VARARGS,
     "Write the refraction of the table's program [deg]: (zd, refraction)."},
    {"table_rows", table_rows, METH_VARARGS,
     "Return a table's text.\n\n"
     "(azimuths as text, characters of one, zenith distances, characters of one, characters of\n"
     "an offset, d_az, d_zd [deg])."},
    {"levels", levels, METH_NOARGS, "Return the instruction sets that can be chosen, best first."},
    {"level", level, METH_NOARGS, "Return the instruction set in use."},
    {"choose", choose, METH_VARARGS, "Use an instruction set of `levels`."},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "pyport_kernel",
    "The loops of pyport.pointing and pyport.steering, compiled.", -1, methods,
    NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit_pyport_kernel(void)
{
    for (int n = COUNT - 1; n >= 0; n--)
        if (has(LEVELS[n]))
            chosen = LEVELS[n];
    PyObject *module = PyModule_Create(&definition);
    if (module && PyModule_AddIntConstant(module, "INTERFACE", 7) < 0)
        Py_CLEAR(module);
    return module;
}
