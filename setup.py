"""What pyproject.toml cannot say: the examples and the documentation go with the program, as folders of its package."""

from setuptools import find_packages, setup

FOLDERS = {"assessment.examples": "projects", "assessment.docs": "docs"}  # as installed: as in the checkout

setup(
    packages=[*find_packages(include=["assessment*", "mechanics*", "templates"]), *FOLDERS],
    package_dir=FOLDERS,
    package_data={
        "assessment": ["py.typed", "ntc/allegato_b.npz"],
        "assessment.examples": ["*/README.md", "*/*.dxf", "*/project.toml", "*/records/*"],
        "assessment.docs": ["*.md", "*/*.md", "*/*.svg", "*/*.png"],
        "mechanics": ["py.typed"],
        "templates": ["*", "*/*"],
    },
    exclude_package_data={"templates": ["__pycache__/*", "*.pyc"]},
    include_package_data=False,
)
