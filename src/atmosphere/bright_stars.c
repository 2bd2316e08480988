/* SPDX-License-Identifier: Apache-2.0 */
/* The brightest stars: right ascension and declination of J2000 in degrees, V and B − V from the Bright Star Catalogue
 * (Hoffleit and Warren 1991, "The Bright Star Catalogue, 5th Revised Edition"; Alnitak, a double star there, from
 * Hipparcos). Doubles closer than an arc minute are one entry, except Alpha Centauri. */
#include "atmosphere/stars.h"

static const np_star bright_stars[] = {
    {101.2871f, -16.7161f, -1.46f, 0.00f}, /* Sirius */
    {95.9879f, -52.6956f, -0.72f, 0.15f},  /* Canopus */
    {219.9021f, -60.8339f, -0.01f, 0.71f}, /* Rigil Kentaurus */
    {219.8963f, -60.8372f, 1.33f, 0.88f},  /* Toliman */
    {213.9154f, 19.1825f, -0.04f, 1.23f},  /* Arcturus */
    {279.2346f, 38.7836f, 0.03f, 0.00f},   /* Vega */
    {79.1725f, 45.9981f, 0.08f, 0.80f},    /* Capella */
    {78.6346f, -8.2017f, 0.12f, -0.03f},   /* Rigel */
    {114.8254f, 5.2250f, 0.38f, 0.42f},    /* Procyon */
    {24.4283f, -57.2367f, 0.46f, -0.16f},  /* Achernar */
    {88.7929f, 7.4069f, 0.50f, 1.85f},     /* Betelgeuse */
    {210.9558f, -60.3731f, 0.61f, -0.23f}, /* Hadar */
    {297.6958f, 8.8683f, 0.77f, 0.22f},    /* Altair */
    {186.6496f, -63.0992f, 0.76f, -0.24f}, /* Acrux */
    {68.9800f, 16.5092f, 0.85f, 1.54f},    /* Aldebaran */
    {247.3517f, -26.4319f, 0.96f, 1.83f},  /* Antares */
    {201.2983f, -11.1614f, 0.98f, -0.23f}, /* Spica */
    {116.3287f, 28.0261f, 1.14f, 1.00f},   /* Pollux */
    {344.4129f, -29.6222f, 1.16f, 0.09f},  /* Fomalhaut */
    {310.3579f, 45.2803f, 1.25f, 0.09f},   /* Deneb */
    {191.9300f, -59.6886f, 1.25f, -0.23f}, /* Mimosa */
    {152.0929f, 11.9672f, 1.35f, -0.11f},  /* Regulus */
    {104.6562f, -28.9722f, 1.50f, -0.21f}, /* Adhara */
    {113.6500f, 31.8883f, 1.58f, 0.03f},   /* Castor */
    {187.7913f, -57.1133f, 1.63f, 1.59f},  /* Gacrux */
    {263.4021f, -37.1039f, 1.63f, -0.22f}, /* Shaula */
    {81.2829f, 6.3497f, 1.64f, -0.22f},    /* Bellatrix */
    {81.5729f, 28.6075f, 1.65f, -0.13f},   /* Elnath */
    {138.3000f, -69.7172f, 1.68f, 0.00f},  /* Miaplacidus */
    {84.0533f, -1.2019f, 1.70f, -0.19f},   /* Alnilam */
    {332.0583f, -46.9611f, 1.74f, -0.13f}, /* Alnair */
    {85.1896f, -1.9428f, 1.74f, -0.20f},   /* Alnitak */
    {193.5071f, 55.9597f, 1.77f, -0.02f},  /* Alioth */
    {165.9321f, 61.7508f, 1.79f, 1.07f},   /* Dubhe */
    {51.0808f, 49.8611f, 1.79f, 0.48f},    /* Mirfak */
    {107.0979f, -26.3933f, 1.84f, 0.68f},  /* Wezen */
    {276.0429f, -34.3847f, 1.85f, -0.03f}, /* Kaus Australis */
    {125.6283f, -59.5094f, 1.86f, 1.28f},  /* Avior */
    {206.8850f, 49.3133f, 1.86f, -0.19f},  /* Alkaid */
    {264.3296f, -42.9978f, 1.87f, 0.40f},  /* Sargas */
    {89.8821f, 44.9475f, 1.90f, 0.03f},    /* Menkalinan */
    {252.1662f, -69.0278f, 1.92f, 1.44f},  /* Atria */
    {99.4279f, 16.3992f, 1.93f, 0.00f},    /* Alhena */
    {306.4121f, -56.7350f, 1.94f, -0.20f}, /* Peacock */
    {95.6750f, -17.9558f, 1.98f, -0.23f},  /* Mirzam */
    {141.8967f, -8.6586f, 1.98f, 1.44f},   /* Alphard */
    {31.7933f, 23.4625f, 2.00f, 1.15f},    /* Hamal */
    {37.9546f, 89.2642f, 2.02f, 0.60f},    /* Polaris */
    {283.8163f, -26.2967f, 2.02f, -0.22f}, /* Nunki */
    {10.8975f, -17.9867f, 2.04f, 1.02f},   /* Diphda */
    {211.6708f, -36.3700f, 2.06f, 1.01f},  /* Menkent */
    {17.4329f, 35.6206f, 2.06f, 1.58f},    /* Mirach */
    {2.0971f, 29.0906f, 2.06f, -0.11f},    /* Alpheratz */
    {86.9392f, -9.6697f, 2.06f, -0.17f},   /* Saiph */
    {222.6763f, 74.1556f, 2.08f, 1.47f},   /* Kochab */
    {263.7337f, 12.5600f, 2.08f, 0.15f},   /* Rasalhague */
    {340.6671f, -46.8847f, 2.10f, 1.60f},  /* Tiaki */
    {47.0421f, 40.9556f, 2.12f, -0.05f},   /* Algol */
    {177.2650f, 14.5719f, 2.14f, 0.09f},   /* Denebola */
    {190.3792f, -48.9600f, 2.17f, -0.01f}, /* Muhlifain */
    {305.5571f, 40.2567f, 2.20f, 0.68f},   /* Sadr */
    {136.9992f, -43.4325f, 2.21f, 1.66f},  /* Suhail */
    {233.6721f, 26.7147f, 2.23f, -0.02f},  /* Alphecca */
    {10.1267f, 56.5372f, 2.23f, 1.17f},    /* Schedar */
    {269.1517f, 51.4889f, 2.23f, 1.52f},   /* Eltanin */
    {83.0017f, -0.2992f, 2.23f, -0.22f},   /* Mintaka */
    {139.2725f, -59.2753f, 2.25f, 0.18f},  /* Aspidiske */
    {120.8958f, -40.0033f, 2.25f, -0.26f}, /* Naos */
    {30.9750f, 42.3297f, 2.26f, 1.37f},    /* Almach */
    {2.2946f, 59.1497f, 2.27f, 0.34f},     /* Caph */
    {200.9812f, 54.9253f, 2.27f, 0.02f},   /* Mizar */
    {252.5408f, -34.2933f, 2.29f, 1.15f},  /* Larawag */
    {220.4825f, -47.3883f, 2.30f, -0.20f}, /* Uridim */
    {240.0833f, -22.6217f, 2.32f, -0.12f}, /* Dschubba */
    {165.4604f, 56.3825f, 2.37f, -0.02f},  /* Merak */
    {221.2467f, 27.0742f, 2.37f, 0.97f},   /* Izar */
    {326.0467f, 9.8750f, 2.39f, 1.53f},    /* Enif */
    {6.5713f, -42.3061f, 2.39f, 1.09f},    /* Ankaa */
    {265.6221f, -39.0300f, 2.41f, -0.22f}, /* Girtab */
    {345.9438f, 28.0828f, 2.42f, 1.67f},   /* Scheat */
    {178.4575f, 53.6947f, 2.44f, 0.00f},   /* Phecda */
    {319.6450f, 62.5856f, 2.44f, 0.22f},   /* Alderamin */
    {111.0238f, -29.3031f, 2.45f, -0.08f}, /* Aludra */
    {311.5529f, 33.9703f, 2.46f, 1.03f},   /* Aljanah */
    {14.1771f, 60.7167f, 2.47f, -0.15f},   /* Navi */
    {346.1904f, 15.2053f, 2.49f, -0.04f},  /* Markab */
    {45.5700f, 4.0897f, 2.53f, 1.64f},     /* Menkar */
    {21.4542f, 60.2353f, 2.68f, 0.13f},    /* Ruchbah */
    {183.7862f, -58.7489f, 2.80f, -0.23f}, /* Imai */
    {56.8713f, 24.1050f, 2.87f, -0.09f},   /* Alcyone */
    {183.8567f, 57.0325f, 3.31f, 0.08f},   /* Megrez */
    {28.5987f, 63.6700f, 3.38f, -0.15f},   /* Segin */
};

np_star_catalogue np_star_catalogue_bright(void) {
  return (np_star_catalogue){.count = sizeof bright_stars / sizeof *bright_stars, .stars = bright_stars};
}
