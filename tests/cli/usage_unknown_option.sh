# SPDX-License-Identifier: Apache-2.0
nephos render scene.yaml --sampels 4
