# SPDX-License-Identifier: Apache-2.0
nephos schema | head -n 8
